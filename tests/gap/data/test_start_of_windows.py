"""Where windows start: the measured motion there, and that a model which is true costs no more than noise however quick the motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import rig_from_text
from config.schema.rig import Rig
from gap.data.local_motion import local_motion, rate_noise
from gap.data.measured import load
from gap.data.windows import prepare
from gap.fitting.evaluation import evaluate
from gap.fitting.model import Model
from sim_backend.plant import SimulatedRig
from tests.support.gap import axis_logs

NOISE = 2e-6
PERIOD_S = 1e-3
HIDDEN = {
    "nothing": "",
    "late command": "    - {effect: transport_delay, where: axis, delay: 4 ms}\n",
    "late sensor": "    - {effect: sensor_delay, where: sensor:axis.position, delay: 4 ms}\n",
    "slow valve": "    - {effect: valve_lag, where: axis, time_constant: 4 ms, damping_ratio: 0.7}\n",
    "late by a part of a step": "    - {effect: transport_delay, where: axis, delay: 3.3 ms}\n",
}


def motion(t: np.ndarray, order: int = 0) -> np.ndarray:
    """A cubic and its derivatives."""
    return np.polyval(np.polyder(np.poly1d([3.0, -2.0, 0.5, 0.1]), order), t)


def test_a_cubic_is_followed_exactly() -> None:
    t = PERIOD_S * np.arange(400)
    found = local_motion(motion(t), 1e-9, PERIOD_S, 15, 1.0)
    for order in range(3):
        np.testing.assert_allclose(found[order][20:-20], motion(t, order)[20:-20], rtol=1e-6, atol=1e-6)


def test_quick_motion_keeps_its_velocity_and_slow_motion_its_quiet() -> None:
    t = PERIOD_S * np.arange(4000)
    noise = np.random.default_rng(1).normal(0, NOISE, t.size)
    quick = 2e-4 * np.sin(2 * np.pi * 30 * t)
    rate_sd = 4e-3 / 3
    _, rate, _ = local_motion(quick + noise, NOISE, PERIOD_S, 15, rate_sd)
    true = np.gradient(quick, PERIOD_S)
    assert np.sqrt(np.mean((rate - true)[50:-50] ** 2)) < 0.05 * np.std(true)
    _, rate, _ = local_motion(1e-3 * t + noise, NOISE, PERIOD_S, 15, rate_sd)
    assert np.std(rate[50:-50]) < 1.5 * NOISE * rate_noise(2, 15, PERIOD_S)


def test_rows_beside_a_gap_have_no_motion() -> None:
    read = np.linspace(0, 1, 300)
    read[150:160] = np.nan
    value, rate, _ = local_motion(read, 1e-3, PERIOD_S, 5, 1.0)
    assert np.isnan(rate[148:162]).all()
    assert np.isfinite(rate[:140]).all()
    assert np.isfinite(value[170:]).all()


def quick_run(rig: Rig, seed: int) -> axis_logs.Columns:
    """The axis shaken by its command between 2 and 40 Hz, 8 V at most, in 10 s."""
    t = PERIOD_S * np.arange(10_000)
    draw = np.random.default_rng(seed)
    waves = [np.sin(2 * np.pi * (f * t + draw.uniform())) for f in np.linspace(2, 40, 24)]
    command = np.sum(waves, axis=0)
    command *= 8.0 * np.minimum(t / 0.5, 1.0) / np.abs(command).max()
    plant = SimulatedRig(rig, seed)
    plant.reset([0.12])
    raw = plant.run(command[:, None], PERIOD_S, sense=True)["raw"]
    return {"t_s": t, "axis.position": raw[:, 0] * 1e-6, "axis.command_V": command}


@pytest.mark.parametrize("hidden", HIDDEN)
def test_the_true_model_of_a_quick_motion_costs_what_noise_costs(hidden: str, tmp_path: Path) -> None:
    rig = rig_from_text(axis_logs.axis_text() + HIDDEN[hidden])
    log = load(axis_logs.write(tmp_path / "a.csv", quick_run(rig, 7)), rig)
    experiment = prepare(log, rig, {"axis.position": np.hypot(NOISE, 1e-6 / np.sqrt(12))}, 0.2, ["axis.position"])
    seen = evaluate(experiment, Model(rig, (), np.empty(0)), None)
    values = experiment.measured[0].size
    even = 1.0 - 2.0 / values  # two start states are free
    assert seen.window_costs.mean() == pytest.approx(even, abs=4 * np.sqrt(2.0 / (values * experiment.windows)))
    assert seen.window_costs.max() < 1.0 + 6.0 * np.sqrt(2.0 / values)
