"""Where the gap is, from logs that were sampled at different rates: each log counts on its own grid, none dilutes another."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from config.schema.rig import Rig
from gap.data.measured import on_grid
from gap.data.windows import prepare
from gap.fitting.evaluation import Evaluation, evaluate
from gap.fitting.model import Model
from gap.outcome.localise import localise
from gap.outcome.spectrum_left import band, spectrum
from tests.support.gap import axis_logs

PERIODS_S = (0.001, 0.0025, 0.01)
SINE_HZ = 20.0


@pytest.fixture(scope="module")
def rig() -> Rig:
    return axis_logs.axis_rig()


@pytest.fixture(scope="module")
def simulated(rig: Rig) -> list[Evaluation]:
    return [of_log(rig, period_s, seed) for seed, period_s in enumerate(PERIODS_S, 1)]


def of_log(rig: Rig, period_s: float, seed: int) -> Evaluation:
    columns = axis_logs.simulated(rig, seed, 12.0, period_s)
    log = on_grid(Path(f"{seed}.csv"), columns, rig, str(seed))
    return evaluate(prepare(log, rig, {"axis.position": 2e-6}, 0.2, ["axis.position"]), Model(rig, (), np.empty(0)), None)


def with_left(evaluation: Evaluation, amplitude: float) -> Evaluation:
    """White noise of the floor's size, and a sine (noise units)."""
    shape = evaluation.experiment.measured.shape
    noise = np.random.default_rng(shape[1]).standard_normal(shape)
    wave = amplitude * np.sin(2 * np.pi * SINE_HZ * evaluation.experiment.times_s)[:, :, None]
    left = np.zeros_like(evaluation.left)
    left[:, : noise[0].size] = (noise + wave).reshape(shape[0], -1)
    return replace(evaluation, left=left, channel_costs=np.mean((noise + wave) ** 2, axis=(0, 1)))


def test_noise_of_the_floors_size_is_one_at_every_frequency(simulated: list[Evaluation]) -> None:
    frequency, density = spectrum([with_left(e, 0.0) for e in simulated], 0)
    assert frequency[-1] > 150.0
    assert density.mean() == pytest.approx(1.0, abs=0.05)
    assert density.min() > 0.5
    assert density.max() < 2.0


def test_a_sine_is_found_at_its_frequency_at_every_mixture_of_rates(simulated: list[Evaluation]) -> None:
    for chosen in ([0], [1], [2], [0, 2], [2, 0], [0, 1, 2]):
        low, high = band([with_left(simulated[k], 10.0) for k in chosen], 0)
        assert SINE_HZ - 10.0 <= low <= SINE_HZ <= high <= SINE_HZ + 10.0


def test_a_log_without_the_channel_dilutes_nothing(simulated: list[Evaluation]) -> None:
    loud = with_left(simulated[0], 10.0)
    blank = np.full_like(simulated[1].experiment.measured, np.nan)
    deaf = replace(
        with_left(simulated[1], 0.0), experiment=replace(simulated[1].experiment, measured=blank), channel_costs=np.array([np.nan])
    )
    np.testing.assert_allclose(spectrum([loud, deaf], 0)[1], spectrum([loud], 0)[1])


def test_a_log_is_heard_up_to_its_own_rate_alone(simulated: list[Evaluation]) -> None:
    """The slow log's sine counts below 50 Hz by its windows; above, the fast log stands by itself."""
    fast, slow = with_left(simulated[0], 0.0), with_left(simulated[2], 10.0)
    frequency, together = spectrum([fast, slow], 0)
    alone = spectrum([fast], 0)[1]
    np.testing.assert_allclose(together[frequency > 51.0], alone[frequency > 51.0])
    at = int(np.argmin(np.abs(frequency - SINE_HZ)))
    share = slow.experiment.windows / (slow.experiment.windows + fast.experiment.windows)
    own_frequency, own = spectrum([slow], 0)
    expected = share * np.interp(frequency[at], own_frequency, own) + (1 - share) * alone[at]
    assert together[at] == pytest.approx(expected, rel=1e-9)


def test_logs_of_different_rates_are_localised_together(simulated: list[Evaluation], rig: Rig) -> None:
    (place,) = localise([with_left(e, 10.0) for e in simulated], ["axis.position"], None, rig)
    assert place.channel == "axis.position"
    assert place.band_Hz[0] <= SINE_HZ <= place.band_Hz[1]
