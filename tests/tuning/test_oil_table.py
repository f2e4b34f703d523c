"""Oil compensation on the simulated rig: the table against hydraulics by hand, and five hours of warming up."""

from __future__ import annotations

from math import degrees, radians, sqrt
from pathlib import Path

import numpy as np
import pytest

from config.load import LoadedRig, load_rig, rig_from_text
from config.overrides import apply_overrides
from config.rig import Rig
from daemon.lockstep import run_lockstep
from recording.reader import read_log
from recording.replay import reexecute
from tuning.line_run import plan_line
from tuning.oil_from_logs import oil_rows, steady_motion
from tuning.oil_table import OilRow, as_override, oil_table
from tuning.paper.rows_figures import five_hours
from tuning.variants import with_servo
from tuning.warm_up_run import heat_at, lags

HOUR_S = 3600.0


def _compensated(joints: tuple[str, ...] = ("rotary", "prismatic")) -> LoadedRig:
    loaded = load_rig("ornl_testbed")
    changes = [as_override(loaded.rig, joint, f"{joint}.return_temperature", oil_table(loaded.rig, joint)) for joint in joints]
    text = apply_overrides(loaded.text, changes)
    return LoadedRig(rig_from_text(text), text, loaded.path)


@pytest.mark.parametrize(("temperature_C", "viscosity_cSt"), [(20.0, 92.7), (60.0, 23.4)])
def test_the_line_goes_through_the_steady_state_by_hand(rig: Rig, temperature_C: float, viscosity_cSt: float) -> None:
    """15 °/s: friction makes a load pressure, the pressure a leak, and displaced and leaked flow pass the valve's two lands."""
    (row,) = oil_table(rig, "rotary", [temperature_C])
    displacement, speed, warmer = 1.63871e-4, radians(15.0), temperature_C - 40.0
    viscous = 1000.0 * (0.5 + 0.5 * viscosity_cSt / 43.0)
    load_Pa = (105.0 * (1.0 - 0.004 * warmer) + viscous * speed) / displacement
    flow = displacement * speed + 4.45e-12 * 43.0 / viscosity_cSt * load_Pa
    opening = flow / (5.0971e-7 * sqrt(0.5 * (13.79e6 - load_Pa)))
    assert row.slope * speed + row.friction_V == pytest.approx(9.08 * opening, rel=0.06)  # the true curve bends
    assert row.bias_V == pytest.approx(0.0, abs=1e-6)  # equal areas


@pytest.mark.slow
def test_five_hours_of_warming_up(rig: Rig) -> None:
    """Error over the moves, from the first move at 22 °C to one after 4.8 hours at 58 °C; adaptive filter, both joints compensated."""
    moments = [0.0, 1.0 * HOUR_S, 2.0 * HOUR_S, 4.8 * HOUR_S]
    heat = heat_at(rig, five_hours(), moments, 22.0)
    plan = plan_line(rig, "paper_line", {"kind": "adaptive"})
    without = with_servo(rig, "rotary", oil_compensation=None)
    plain, compensated = (lags(each, plan, moments, heat) for each in (without, _compensated().rig))
    rotary = np.array([[degrees(lag.rms[0]) for lag in run] for run in (plain, compensated)])
    prismatic = np.array([[1e3 * lag.rms[1] for lag in run] for run in (plain, compensated)])
    assert 55.0 < plain[-1].oil_C < 60.0
    assert rotary[0, -1] > 0.15
    assert rotary[1, -1] < 0.05
    assert np.all(rotary[1] < 0.7 * rotary[0])
    assert prismatic[0, -1] > 1.0
    assert prismatic[1, -1] < 0.3
    assert np.ptp(prismatic[1]) < 0.1  # flat over the five hours


def test_a_compensated_run_re_executes_bit_for_bit(tmp_path: Path) -> None:
    jog = {"maneuver": {"name": "jog"}}
    (log,) = run_lockstep(_compensated(("rotary",)), [jog], tmp_path)
    assert reexecute(log).identical
    assert not reexecute(log, ("servo.rotary.oil_compensation.source=reservoir_temperature",)).identical


@pytest.mark.slow
def test_logs_of_ordinary_moves_give_the_same_table(rig: Rig, tmp_path: Path) -> None:
    """The cylinder at 55 °C, 0.1 and 0.16 m/s in both directions: within 0.1 V of the table; the shipped constant is 0.25 V off."""
    loaded = load_rig("ornl_testbed")
    text = apply_overrides(loaded.text, ["plant.oil.initial_temperature=55 degC"])
    request = {"maneuver": {"name": "paper_line"}, "shaper": {"kind": "adaptive"}, "approach": True}
    (path,) = run_lockstep(LoadedRig(rig_from_text(text), text, loaded.path), [request], tmp_path)
    (row,) = oil_rows([steady_motion(read_log(path), rig, "prismatic")])
    (table,) = oil_table(rig, "prismatic", [55.0])
    assert row.temperature_C == pytest.approx(55.0, abs=1.5)
    for rate in (-0.16, -0.1, 0.1, 0.16):
        assert _volts(row, rate) == pytest.approx(_volts(table, rate), abs=0.1)
    shipped = rig.servo["prismatic"].velocity_feedforward
    assert max(abs(_volts(row, rate) - shipped * rate) for rate in (-0.1, 0.1)) > 0.25


def _volts(row: OilRow, rate: float) -> float:
    return row.slope * rate + row.friction_V * np.sign(rate) + row.bias_V
