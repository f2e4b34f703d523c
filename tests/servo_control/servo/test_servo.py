"""One joint's servo in a loop with simple plants: tracking, limits, anti-windup, velocity."""

from __future__ import annotations

from math import degrees, exp, nan, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from config.schema.rig import Rig
from config.schema.servo import LagLeadSection
from servo_control.numerics.limits import CommandLimit, ReferenceLimit
from servo_control.path.joint_limits import in_joint_units, joint_limits
from servo_control.servo.servo import JointServo
from servo_control.servo.velocity import VelocityEstimate

PERIOD_S = 0.001
RATE_PER_VOLT = 43.09 * pi / 180  # rad/s per V of the testbed's rotary joint
DESIGN_C = (LagLeadSection(zero=44.04, pole=440.4), LagLeadSection(zero=8.0, pole=4 / 3))


def _servo(rig: Rig, *, sections: tuple[LagLeadSection, ...] = (), gain: float | None = None, limit_V: float = 5.0) -> JointServo:
    change = {"sections": sections, "gain": rig.servo["rotary"].gain if gain is None else gain}
    joint = rig.joints["rotary"].model_copy(update={"command_limit_V": limit_V})
    return JointServo(joint, rig.servo["rotary"].model_copy(update=change), PERIOD_S)


def _engaged(servo: JointServo, position: float) -> JointServo:
    servo.measure(position)
    servo.engage()
    return servo


def test_feed_forward_alone_tracks_an_integrating_joint(rig: Rig) -> None:
    servo, position = _engaged(_servo(rig, gain=0.0), 0.0), 0.0
    for n in range(1000):
        reference, rate = 0.1 * (1 - np.cos(4 * n * PERIOD_S)), 0.4 * np.sin(4 * n * PERIOD_S)
        assert position == pytest.approx(reference, abs=4e-4)
        servo.measure(position)
        servo.step(reference, rate, 0.0)
        position += RATE_PER_VOLT * servo.command_V * PERIOD_S


def test_proportional_loop_has_the_time_constant_of_its_velocity_constant(rig: Rig) -> None:
    """0.35 V/deg × 43.09 (deg/s)/V = 15.08 1/s."""
    servo, position = _engaged(_servo(rig), 0.1), 0.1
    for n in range(300):
        assert position == pytest.approx(0.1 * exp(-15.08 * n * PERIOD_S), abs=0.0015)
        servo.measure(position)
        servo.step(0.0, 0.0, 0.0)
        position += RATE_PER_VOLT * servo.command_V * PERIOD_S


def test_lag_lead_does_not_wind_up_in_a_long_saturated_move(rig: Rig) -> None:
    """A 40 degree error at a limit of 0.5 V takes 2 s of saturation: 0.5 degrees of overshoot, without conditioning 11."""
    servo, position, farthest = _engaged(_servo(rig, sections=DESIGN_C, gain=2.43 * 180 / pi, limit_V=0.5), 0.0), 0.0, 0.0
    for _ in range(6000):
        servo.measure(position)
        servo.step(0.7, 0.0, 0.0)
        position += RATE_PER_VOLT * servo.command_V * PERIOD_S
        farthest = max(farthest, position - 0.7)
    assert degrees(farthest) < 1.0
    assert position == pytest.approx(0.7, abs=1e-3)


@given(st.lists(st.floats(-100, 100), min_size=1, max_size=50), st.floats(0.1, 10), st.floats(1, 5000))
def test_command_limit_holds_both_limits(wanted: list[float], limit_V: float, rate: float) -> None:
    limit, command = CommandLimit(limit_V, rate, PERIOD_S), 0.0
    for value in wanted:
        following = limit.apply(value, command)
        assert abs(following) <= limit_V
        assert abs(following - command) <= rate * PERIOD_S * (1 + 1e-9)
        assert min(command, value) - 1e-12 <= following <= max(command, value) + 1e-12
        command = following


@given(st.lists(st.floats(-3, 3), min_size=1, max_size=50), st.floats(-2, 2))
def test_reference_limit(wanted: list[float], start: float) -> None:
    """Within travel and start, never faster than the rate limit."""
    limit, reference = ReferenceLimit((-1.0, 1.0), 0.5, PERIOD_S), start
    limit.engage(start)
    for value in wanted:
        following = limit.apply(value, reference)
        assert abs(following - reference) <= 0.5 * PERIOD_S * (1 + 1e-6)
        assert min(-1.0, start) - 1e-12 <= following <= max(1.0, start) + 1e-12
        reference = following


def test_velocity_is_the_filtered_derivative() -> None:
    rng = np.random.default_rng(0)
    position = np.cumsum(rng.normal(0, 1e-4, 2000))
    estimate = VelocityEstimate(50.0, PERIOD_S)
    found = [estimate.step(p) for p in position]
    pole = exp(-2 * pi * 50 * PERIOD_S)
    expected = signal.lfilter([1 - pole], [1, -pole], np.diff(position, prepend=position[0]) / PERIOD_S)
    assert np.array(found) == pytest.approx(expected, abs=1e-12)


def test_excitation_stops_outside_the_travel(rig: Rig) -> None:
    servo = _engaged(_servo(rig, gain=0.0), 1.0)
    servo.step(1.0, 0.0, 1.0)
    assert servo.command_V == 1.0
    servo.measure(1.6)
    servo.step(1.6, 0.0, 1.0)
    assert servo.command_V == 0.0


def test_lost_samples_are_bridged_and_a_servo_without_any_has_no_velocity(rig: Rig) -> None:
    servo = _servo(rig)
    servo.measure(nan)
    assert servo.velocity != servo.velocity
    servo.measure(0.25)
    servo.measure(nan)
    assert servo.position == 0.25


@pytest.mark.parametrize(("written", "value"), [(0.1, 0.1), ("0.1 rad", 0.1)])
def test_joint_units(rig: Rig, written: float | str, value: float) -> None:
    assert in_joint_units(written, joint_limits(rig)[0]) == value
