"""The controller's promises cycle by cycle: modes, bumpless changes, the end of a run, lost samples."""

from __future__ import annotations

from math import inf, isnan, nan
from typing import Any

import numpy as np
import pytest

from config.errors import ManeuverError
from config.loading.load import find, load_rig
from config.schema.rig import Rig
from servo_control.controller import Controller
from servo_control.link.kinematics import forward
from servo_control.planning.planning import plan_run
from servo_control.signals import Inputs, Mode
from tests.support.servo_control.ideal_arm import PERIOD_S, IdealArm
from tests.support.servo_control.testbed_runs import INCH, content, request

HOME = [0.0, 30 * INCH]
OFF = [Mode.DISARMED, Mode.ARMING, Mode.FAULT]


@pytest.mark.parametrize("mode", OFF)
def test_off_modes_command_nothing_and_follow(rig: Rig, mode: Mode) -> None:
    controller = Controller(rig)
    for n in range(50):
        position = (0.001 * n, 0.8 + 0.0001 * n)
        out = controller.step(Inputs(n, mode, 0, position, nan, nan))
        assert [j.command_V for j in out.joints] == [0.0, 0.0]
        assert tuple(j.reference for j in out.joints) == position == tuple(j.target for j in out.joints)
        assert not out.finished
        assert not out.stopped
        assert out.segment == 0
    assert out.joints[0].velocity == pytest.approx(1.0, rel=0.01)


def test_holding_keeps_the_position_of_entry(rig: Rig) -> None:
    arm = IdealArm(rig, [0.2, 1.0])
    first = arm.hold(1)
    assert [j.command_V for j in first.joints] == [0.0, 0.0]
    arm.position[0] += 0.01
    pushed = arm.step(Mode.HOLDING)
    assert pushed.joints[0].reference == 0.2
    assert pushed.joints[0].command_V < 0.0
    for _ in range(1000):
        arm.step(Mode.HOLDING)
    assert arm.position[0] == pytest.approx(0.2, abs=1e-6)


def test_line_is_tracked_and_finishes_after_the_last_hold(rig: Rig, paper_y30: dict[str, Any]) -> None:
    arm = IdealArm(rig, HOME)
    plan = plan_run(rig, request(paper_y30, HOME))
    arm.start(plan, 1)
    begin = len(arm.log) - 1
    arm.until(Mode.RUNNING, 1, lambda out: out.finished)
    assert (len(arm.log) - 1 - begin) * PERIOD_S == pytest.approx(plan.duration_s, abs=0.002)
    assert arm.log[begin].segment == 1
    assert arm.log[begin + 3099].segment == 1
    assert arm.log[begin + 3100].segment == 2
    for j in (0, 1):
        error = np.array(arm.column("reference", j)[begin:-1]) - np.array(arm.column("reference", j)[begin + 1 :])
        assert abs(error).max() <= rig.joints[("rotary", "prismatic")[j]].rate_limit * PERIOD_S
    points = np.array([forward(out.joints[0].reference, out.joints[1].reference) for out in arm.log[begin:]])
    assert points[:, 1] == pytest.approx(30 * INCH, abs=1e-9)
    assert points[-1, 0] == pytest.approx(0.0, abs=1e-12)
    assert arm.step(Mode.RUNNING, 1).finished, "finished stays until the mode changes"
    assert arm.step(Mode.HOLDING).joints[1].reference == pytest.approx(30 * INCH)


def test_finished_waits_for_the_shaper(rig: Rig) -> None:
    """A jog without a hold: 2 deg at 2 deg/s and then the flush of a ZVD at 2 Hz, half a second."""
    jog = content("jog", joint="rotary", by="2 deg", speed="2 deg/s")
    arm = IdealArm(rig, HOME)
    plan = plan_run(rig, request(jog, HOME, {"kind": "zvd", "frequency_Hz": 2.0}))
    arm.start(plan, 1)
    arm.until(Mode.RUNNING, 1, lambda out: out.finished)
    assert (len(arm.log) - 7) * PERIOD_S == pytest.approx(plan.motion_end_s + 0.5, abs=0.01)
    assert arm.log[-1].joints[0].reference == pytest.approx(np.radians(2.0), abs=1e-12)


def test_a_run_never_starts_twice(rig: Rig) -> None:
    arm = IdealArm(rig, HOME)
    plan = plan_run(rig, request(content("jog", joint="rotary", by="1 deg"), HOME))
    arm.start(plan, 200)
    moved = arm.step(Mode.FAULT).joints[0].reference
    arm.step(Mode.DISARMED)
    arm.step(Mode.HOLDING)
    for _ in range(300):
        out = arm.step(Mode.RUNNING, 1)
    assert out.joints[0].target == pytest.approx(moved, abs=1e-9)
    assert out.segment == 0
    assert out.finished


@pytest.mark.parametrize("run", [0, 2])
def test_only_the_prepared_run_starts(rig: Rig, run: int) -> None:
    arm = IdealArm(rig, HOME)
    arm.hold()
    arm.controller.prepare(plan_run(rig, request(content("jog", joint="rotary", by="1 deg"), HOME)))
    for _ in range(100):
        out = arm.step(Mode.RUNNING, run)
    assert out.segment == 0
    assert not out.finished
    assert out.joints[0].target == 0.0


def test_start_a_little_beside_the_program_joins_smoothly(rig: Rig, paper_y30: dict[str, Any]) -> None:
    held = [0.003, 30 * INCH + 0.0015]
    arm = IdealArm(rig, held)
    plan = plan_run(rig, request(paper_y30, held))
    arm.start(plan, 1500)
    for j in (0, 1):
        target = np.array(arm.column("target", j)[5:])
        assert abs(np.diff(target)).max() <= 1.05 * 0.36 * PERIOD_S
        assert abs(np.diff(target, 2)).max() <= 5.5 * PERIOD_S**2
    y = [forward(out.joints[0].target, out.joints[1].target)[1] for out in arm.log[1100:]]
    assert y == pytest.approx([30 * INCH] * len(y), abs=1e-12)


def test_hold_on_after_running_without_a_stop_is_a_controlled_stop(rig: Rig, paper_y30: dict[str, Any]) -> None:
    arm = IdealArm(rig, HOME)
    arm.start(plan_run(rig, request(paper_y30, HOME)), 1000)
    for _ in range(1500):
        arm.step(Mode.HOLDING)
    steps = np.diff(arm.column("target_rate", 0)[1000:]) / PERIOD_S
    assert abs(steps).max() <= rig.joints["rotary"].acceleration_limit * 1.001
    assert arm.log[-1].joints[0].target_rate == 0.0
    assert arm.log[-1].segment == 0


@pytest.mark.parametrize("bad", [nan, inf, -inf, 1e300])
def test_lost_samples_do_no_harm(rig: Rig, paper_y30: dict[str, Any], bad: float) -> None:
    """Ten bad samples in the middle of a move, then good ones: the arm is where it would have been."""
    arm, other = IdealArm(rig, HOME), IdealArm(rig, HOME)
    plan = plan_run(rig, request(paper_y30, HOME))
    arm.start(plan, 1500)
    other.start(plan, 1510)
    for _ in range(10):
        arm.step(Mode.RUNNING, 1, spoil=lambda _: bad)
    for _ in range(1000):
        out, right = arm.step(Mode.RUNNING, 1), other.step(Mode.RUNNING, 1)
    assert out.joints[0].reference == right.joints[0].reference
    assert arm.position == pytest.approx(other.position, abs=1e-6)


def test_nothing_moves_before_the_first_good_sample(rig: Rig) -> None:
    controller = Controller(rig)
    for n in range(20):
        out = controller.step(Inputs(n, Mode.HOLDING, 0, (nan, 0.9), nan, nan))
        assert [j.command_V for j in out.joints] == [0.0, 0.0]
        assert isnan(out.joints[0].reference)
    out = controller.step(Inputs(20, Mode.HOLDING, 0, (0.1, 0.9), nan, nan))
    assert [j.reference for j in out.joints] == [0.1, 0.9]


def test_null_bias_is_faded_in(rig: Rig) -> None:
    servo = rig.servo["rotary"].model_copy(update={"null_bias_V": 0.4})
    biased = rig.model_copy(update={"servo": {**rig.servo, "rotary": servo}})
    controller = Controller(biased)
    commands = [controller.step(Inputs(n, Mode.HOLDING, 0, (0.0, 0.9), nan, nan)).joints[0].command_V for n in range(700)]
    assert commands[0] <= 0.001
    assert max(np.diff(commands)) <= 0.001
    assert commands[-1] == pytest.approx(0.4)


def test_outside_the_travel_at_arming_is_not_pulled_in(rig: Rig) -> None:
    arm = IdealArm(rig, [0.0, 12 * INCH - 0.001])
    arm.hold(50)
    assert arm.log[-1].joints[1].reference == 12 * INCH - 0.001
    assert arm.log[-1].joints[1].command_V == 0.0


def test_single_axis_rig_runs(rig: Rig) -> None:
    axis = load_rig(find("rigs", "force_axis")).rig
    controller = Controller(axis)
    controller.prepare(plan_run(axis, request(content("jog", joint="axis", by="10 mm"), [0.0])))
    out = [controller.step(Inputs(n, Mode.HOLDING if n < 2 else Mode.RUNNING, 1, (0.0,), nan, nan)) for n in range(2000)][-1]
    assert out.finished
    assert out.joints[0].target == pytest.approx(0.01)


def test_plan_for_other_joints_is_refused(rig: Rig) -> None:
    axis = load_rig(find("rigs", "force_axis")).rig
    plan = plan_run(axis, request(content("jog", joint="axis", by="10 mm"), [0.0]))
    with pytest.raises(ManeuverError, match="other joints"):
        Controller(rig).prepare(plan)
