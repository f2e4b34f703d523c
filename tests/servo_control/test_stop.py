"""The controlled stop: on the path, within the limits, then the shaper flushes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from config.schema.rig import Rig
from servo_control.link.kinematics import forward
from servo_control.planning.motion import Motion
from servo_control.planning.planning import plan_run
from servo_control.signals import Mode
from tests.support.servo_control.ideal_arm import PERIOD_S, IdealArm
from tests.support.servo_control.testbed_runs import INCH, content, request

HOME = [0.0, 30 * INCH]
MOMENTS_MS = [0, 30, 101, 1500, 3050, 4000, 5150, 8000, 11150, 13250, 16290, 17000]


@pytest.mark.parametrize("moment", MOMENTS_MS)
def test_the_line_stays_straight_and_joints_within_limits(rig: Rig, paper_y30: dict[str, Any], moment: int) -> None:
    arm = IdealArm(rig, HOME)
    arm.start(plan_run(rig, request(paper_y30, HOME)), moment + 1)
    begin = len(arm.log)
    arm.until(Mode.STOPPING, 1, lambda out: out.stopped, most=1500)
    for _ in range(3):
        arm.step(Mode.HOLDING)
    points = np.array([forward(out.joints[0].target, out.joints[1].target) for out in arm.log[5:]])
    assert points[:, 1] == pytest.approx(30 * INCH, abs=1e-9)
    speed = np.diff(points[begin - 10 :, 0]) / PERIOD_S
    assert (np.diff(abs(speed)) <= 1e-6 + 2.54 * PERIOD_S).all()
    assert speed[-1] == 0.0
    for j, joint in enumerate(rig.joints.values()):
        target, rate = np.array(arm.column("target", j)), np.array(arm.column("target_rate", j))
        assert abs(np.diff(rate[begin:])).max() <= (joint.acceleration_limit + 0.3) * PERIOD_S
        assert np.gradient(target, PERIOD_S)[begin:] == pytest.approx(rate[begin:], abs=joint.acceleration_limit * PERIOD_S)
    assert arm.log[-1].joints[0].target_rate == 0.0


def test_shaped_stop_flushes_both_joints_and_stays_near_the_line(rig: Rig, paper_y30: dict[str, Any]) -> None:
    arm = IdealArm(rig, HOME)
    shaper = {"kind": "adaptive", "joints": ["rotary", "prismatic"]}
    arm.start(plan_run(rig, request(paper_y30, HOME, shaper)), 8000)
    out = arm.until(Mode.STOPPING, 1, lambda out: out.stopped, most=2500)
    for joint in out.joints:
        assert joint.reference == pytest.approx(joint.target, abs=1e-9)
        assert joint.reference_rate == pytest.approx(0.0, abs=1e-9)
    bow = [abs(forward(o.joints[0].reference, o.joints[1].reference)[1] - 30 * INCH) for o in arm.log[5:]]
    assert max(bow) < 0.003  # a stop in 50 to 100 ms bends more than the program's own 0.5 mm


def test_stop_is_kept_when_the_mode_goes_back(rig: Rig, paper_y30: dict[str, Any]) -> None:
    arm = IdealArm(rig, HOME)
    arm.start(plan_run(rig, request(paper_y30, HOME)), 1000)
    arm.step(Mode.STOPPING, 1)
    arm.until(Mode.RUNNING, 1, lambda out: out.joints[0].target_rate == 0.0, most=2000)
    rest = arm.step(Mode.RUNNING, 1).joints[0].target
    assert arm.step(Mode.RUNNING, 1).joints[0].target == rest


def test_stopping_without_a_run_is_stopped_at_once(rig: Rig) -> None:
    arm = IdealArm(rig, HOME)
    arm.hold()
    assert arm.step(Mode.STOPPING, 0).stopped


def test_volts_are_taken_away_within_50_ms(rig: Rig) -> None:
    """A joint at rest lets σ go down at its fastest, from 1 to 0 at 20 1/s; the signal is never above its amplitude."""
    sweep = content("sine_sweep", joint="rotary", on="command", amplitude="0.3 V", **{"from": 20.0, "to": 30.0}, duration=10.0, fade=0.5)
    plan = plan_run(rig, request(sweep, HOME))
    joints = rig.joints.values()
    motion = Motion(plan, HOME, [joint.rate_limit for joint in joints], [joint.acceleration_limit for joint in joints], PERIOD_S)
    before = [volts(motion, stop=False) for _ in range(5000)]
    assert max(before[-50:]) > 0.29
    during = np.array([volts(motion, stop=True) for _ in range(100)])
    assert (during <= 0.3 * np.maximum(0.0, 1.0 - 20.0 * PERIOD_S * np.arange(100)) + 1e-12).all()
    assert during[:25].max() > 0.15, "not before it is at rest"
    assert during[50:] == pytest.approx(0.0, abs=1e-12)


def volts(motion: Motion, *, stop: bool) -> float:
    motion.advance(stop=stop)
    assert motion.target == HOME
    return abs(motion.volts[0])
