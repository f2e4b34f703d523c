"""Long logs: windows of every regime of motion are fitted and judge; costs are over all windows of the hold-out."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from config.loading.load import LoadedRig, rig_from_text
from gap.data.experiments import experiments_of
from gap.data.measured import on_grid
from gap.data.strata import MOST_WINDOWS, chosen, regime
from gap.data.windows import velocities
from gap.fitting.model import Model
from gap.outcome.search_state import SearchState, opening_state
from gap.settings import Settings
from tests.support.gap import axis_logs
from tests.support.gap.finished_search import MODEL, quiet


def opened(seconds: float) -> SearchState:
    """A fit log and a hold-out of the single axis, both so long."""
    loaded = LoadedRig(rig_from_text(MODEL), MODEL, "axis.yaml")
    truth = axis_logs.axis_rig()
    logs = [on_grid(Path(f"{seed}.csv"), axis_logs.simulated(truth, seed, seconds), loaded.rig, str(seed)) for seed in (1, 2)]
    names, fitted, held = experiments_of(loaded, logs[:1], logs[1:], Settings(propose=False))
    return opening_state(Model(loaded.rig, (), np.empty(0)), fitted, held, frozenset(names), quiet)


def test_of_a_long_hold_out_no_more_windows_judge_than_are_fitted_of_long_logs() -> None:
    state = opened(40.0)
    (fitted,), (judging,), (whole,) = state.experiments, state.judging, state.holdouts
    assert whole.windows > 1.5 * MOST_WINDOWS
    for log in (fitted, judging):
        assert MOST_WINDOWS <= log.windows < MOST_WINDOWS + 3  # blocks of three
    assert len(state.seen[0].left) == whole.windows


def test_windows_of_a_short_hold_out_all_judge() -> None:
    state = opened(6.0)
    assert state.judging[0] is state.holdouts[0]


def test_every_regime_of_motion_is_among_the_chosen_windows() -> None:
    (whole,) = opened(40.0).holdouts
    speeds = velocities(whole)
    (numbers,) = chosen([speeds])
    there, kept = ({tuple(row) for row in regime(v)} for v in (speeds, speeds[numbers]))
    assert kept == there
