"""Logs that were not sampled evenly, against the motion they were taken from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig
from gap.data.measured import on_grid
from gap.data.uniform_grid import bridged

PERIOD_S = 0.01


def test_jitter_does_not_spoil_a_rate() -> None:
    """A ramp at 10 mm/s sampled up to 3 ms off its grid stays a ramp; the load cell's force, a measurement, is moved with it."""
    draw = np.random.default_rng(1)
    t = PERIOD_S * np.arange(600)
    t[1:] += draw.uniform(-3e-3, 3e-3, 599)
    columns = {"t_s": t, "rod.position": -0.01 * t, "rod.pressure_a_Pa": 1e5 + 1e4 * t, "rod.command_V": 50 + 5 * t}
    log = on_grid(Path("ramp.csv"), columns, load_rig("seal_rig").rig, "")
    inside = np.isfinite(log.channels["rod.position"].values)
    inside[[0, -1]] = False
    assert inside.mean() > 0.85
    assert log.period_s == pytest.approx(PERIOD_S, rel=0.05)
    assert log.channels["rod.position"].values[inside] == pytest.approx((-0.01 * log.t_s)[inside], abs=1e-9)
    assert log.commands_V[inside, 0] == pytest.approx((50 + 5 * log.t_s)[inside], abs=1e-6)


def test_a_drives_command_stays_where_it_stands() -> None:
    draw = np.random.default_rng(2)
    t = PERIOD_S * np.arange(600)
    t[1:] += draw.uniform(-2e-3, 2e-3, 599)
    steps = np.repeat(draw.normal(size=60), 10)
    log = on_grid(Path("steps.csv"), {"t_s": t, "axis.position": 0.1 * t, "axis.command_V": steps}, load_rig("force_axis").rig, "")
    assert set(np.unique(log.commands_V)) <= set(np.unique(steps))


def test_single_lost_rows_are_bridged_and_long_gaps_are_not() -> None:
    values = np.arange(20.0)
    values[[3, 8, 9]] = np.nan
    values[12:17] = np.nan
    filled = bridged(values)
    assert filled[[3, 8, 9]] == pytest.approx([3.0, 8.0, 9.0])
    assert np.isnan(filled[12:17]).all()
