"""From logs to what is compared: the channels, and every log cut into windows."""

from __future__ import annotations

from collections.abc import Sequence

from config.loading.load import LoadedRig
from gap.data.measured import Measured, compared
from gap.data.noise import noise_floors
from gap.data.window_length import window_length_s
from gap.data.windows import Experiment, left_in, prepare
from gap.settings import Settings


def experiments_of(
    loaded: LoadedRig, fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], settings: Settings
) -> tuple[list[str], list[Experiment], list[Experiment]]:
    """Channels that some fit log has, and the logs cut into windows; a log has no values in a channel it lacks. LogError where the windows
    left in all fit logs, or in all hold-out logs, are too few."""
    every = [*fit_logs, *holdout_logs]
    names = compared(dict.fromkeys(name for log in fit_logs for name in log.channels), loaded.rig)
    sigma = noise_floors(every, loaded.rig)
    window_s = settings.window_s or window_length_s(loaded.rig, every, sigma)
    cut = [prepare(log, loaded.rig, sigma, window_s, names, settings.workers) for log in every]
    return names, left_in(cut[: len(fit_logs)], "--log"), left_in(cut[len(fit_logs) :], "--holdout")
