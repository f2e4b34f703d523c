"""A servo that shakes its joint: the share at both limits by its closed form, and unstable servos of simulated rigs."""

from __future__ import annotations

from math import exp
from pathlib import Path

import pytest

from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from daemon.checks.declared.hunting import HUNTING, MEAN_S, HuntingWatch
from daemon.checks.interlocks import rig_facts
from daemon.lockstep import LockstepRig
from servo_control.signals import Mode

RIG = load_rig("force_axis").rig


def share_after(commands_V: list[float], mode: Mode = Mode.HOLDING) -> float:
    facts = rig_facts(RIG)
    values, watch = facts.blank(), HuntingWatch(RIG, facts)
    values[facts.index("mode")] = float(mode)
    for command_V in commands_V:
        values[facts.index("axis.command_V")] = command_V
        watch.update(values, 0, 0)
    return values[facts.index(f"axis.{HUNTING}")]


def test_from_limit_to_limit_it_comes_to_one_as_a_first_order_lag_does() -> None:
    full_V, cycles = RIG.joints["axis"].command_limit_V, round(MEAN_S * RIG.loop.rate_Hz)
    swing = [full_V, -full_V] * (cycles // 2)
    assert share_after(swing) == pytest.approx(1.0 - exp(-1.0), abs=2e-3)
    assert share_after(10 * swing) == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("commands_V", [[10.0], [-10.0], [9.0, -9.0], [0.0]], ids=["held up", "the other way", "within", "none"])
def test_one_side_alone_and_swings_within_the_limits_are_none(commands_V: list[float]) -> None:
    assert share_after(commands_V * 5000) == 0.0


def test_without_the_servo_nothing_hunts() -> None:
    assert share_after([10.0, -10.0] * 5000, Mode.DISARMED) == 0.0


@pytest.mark.parametrize(("rig", "joint"), [("rotary_actuator", "shaft"), ("ornl_testbed", "rotary"), ("ornl_testbed", "prismatic")])
def test_sixty_times_the_gain_is_a_fault_whatever_the_following_error_may_be(rig: str, joint: str, tmp_path: Path) -> None:
    """A gain per degree for one per radian. With wide limits nothing else stops the arm."""
    base = load_rig(rig)
    unit = base.rig.joints[joint].position_unit
    changes = [f"servo.{joint}.gain={60 * base.rig.servo[joint].gain} V/{unit}", f"joints.{joint}.following_error_limit=0.5 {unit}"]
    text = apply_overrides(base.text, changes)
    with LockstepRig(LoadedRig(rig_from_text(text), text, "rig.yaml"), tmp_path) as running:
        running.arm()
        low, high = base.rig.joints[joint].travel
        maneuver = f"longreach: maneuver/1\nname: short\nkind: jog\njoint: {joint}\nby: {0.05 * (high - low)}\n"
        running.start({"maneuver": {"text": maneuver, "name": "short"}, "countdown_s": 0.0})
        running.until(lambda: running.mode is Mode.FAULT, 10.0)
        assert f"{joint} hunting" in running.loop.keeper.why_fault
