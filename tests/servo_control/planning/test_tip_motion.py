"""How fast a run moves the tip: against differences of the tip's place, against the shapes of the ramps, and the interlock's limit."""

from __future__ import annotations

import json
from dataclasses import asdict
from math import cos, sin

import numpy as np
import pytest

from config.errors import ManeuverError
from config.loading.load import load_rig
from config.schema.rig import Rig
from servo_control.link.kinematics import forward
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan, TipMotion
from tests.support.servo_control.testbed_runs import INCH, content, request, shipped

HOME = [0.0, 40 * INCH]


@pytest.fixture(scope="module")
def testbed() -> Rig:
    return load_rig("ornl_testbed").rig


def _limited(rig: Rig, most: float) -> Rig:
    return rig.model_copy(update={"interlocks": rig.interlocks.model_copy(update={"tip_acceleration_max_m_per_s2": most})})


def _line(rig: Rig, kind: str) -> RunPlan:
    return plan_run(rig, request(shipped("paper_line"), HOME, {"kind": kind}))


@pytest.mark.parametrize("kind", ["none", "adaptive_zv", "zero_delay"])
def test_peaks_are_those_of_the_tip_in_the_plane(testbed: Rig, kind: str) -> None:
    """Places of the tip every millisecond, differences once and twice; across the link is at right angles to hub and tip."""
    plan = _line(testbed, kind)
    step = 0.001
    joints = np.array([plan.program.at(n * step, plan.program.index_at(n * step))[0] for n in range(round(plan.motion_end_s / step))])
    places = np.array([forward(theta, length, testbed.arm.hub_offset_m) for theta, length in joints])
    velocity = np.diff(places, axis=0) / step
    acceleration = np.diff(places, 2, axis=0) / step**2
    across = np.array([(-cos(theta), -sin(theta)) for theta in joints[1:-1, 0]])
    assert plan.tip is not None
    assert plan.tip.speed_mps == pytest.approx(np.hypot(*velocity.T).max(), rel=1e-3)
    assert plan.tip.acceleration_mps2 == pytest.approx(np.abs(np.sum(across * acceleration, axis=1)).max(), rel=1e-2)


def test_what_ramps_without_corners_ask_for(testbed: Rig) -> None:
    """Planned: 10 in/s and 100 in/s², across the link where the line begins. `adaptive_zv`: 1.3 of the speed, less acceleration."""
    plain, smooth = (_line(testbed, kind).tip for kind in ("none", "adaptive_zv"))
    assert plain is not None
    assert smooth is not None
    assert plain.speed_mps == smooth.planned_speed_mps == pytest.approx(10 * INCH)
    assert plain.acceleration_mps2 == smooth.planned_acceleration_mps2 == pytest.approx(100 * INCH)
    assert smooth.speed_mps == pytest.approx(13 * INCH)
    assert smooth.acceleration_mps2 < plain.acceleration_mps2
    assert plain.limit_mps2 == testbed.interlocks.tip_acceleration_max_m_per_s2


def test_the_line_that_the_operator_reads(testbed: Rig) -> None:
    """Through JSON, as a client of the daemon has it."""
    told = json.loads(json.dumps(_line(testbed, "adaptive_zv").summary()))["tip"]
    text = TipMotion(**told).text()
    assert text.startswith("the tip reaches 0.33 m/s (0.254 m/s planned, × 1.30); the tip's acceleration across the link 0.781 m/s^2 ")
    assert "(limit 39.23 m/s^2); prismatic " in text
    free = TipMotion(**{**told, "limit_mps2": None, "speed_mps": 0.254}).text()
    assert "(0.254 m/s planned)" in free
    assert "no limit in the rig file" in free


@pytest.mark.slow
def test_more_than_the_interlock_bears_is_refused(testbed: Rig) -> None:
    """1 m/s²: too little for the line as written, enough for its smooth ramps, and for a correction at less pace."""
    strict = _limited(testbed, 1.0)
    with pytest.raises(ManeuverError, match=r"tip_acceleration_max: 2\.54"):
        _line(strict, "none")
    assert _line(strict, "adaptive_zv").tip is not None
    with pytest.raises(ManeuverError, match=r"It is possible at .* of its pace"):
        _line(strict, "zero_delay")
    plan_run(_limited(testbed, 2.6), request(shipped("paper_line"), HOME))


def test_an_arm_without_tip_and_a_hold() -> None:
    axis = load_rig("rotary_actuator").rig
    assert plan_run(axis, request(content("hold", duration=1.0), [0.0])).tip is None
    still = plan_run(load_rig("ornl_testbed").rig, request(content("hold", duration=1.0), HOME)).tip
    assert still is not None
    assert (still.speed_mps, still.acceleration_mps2, still.rate_share) == (0.0, 0.0, 0.0)
    assert "× " not in TipMotion(**asdict(still)).text()
