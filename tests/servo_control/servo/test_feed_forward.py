"""What the servo adds to its feedback, with the feedback off: feed-forward of rate and acceleration, and the dither."""

from __future__ import annotations

import pytest

from config.schema.rig import Rig
from servo_control.servo.servo import JointServo

PERIOD_S = 0.001
K_V, K_A, DITHER_V = 1.3, 0.025, 0.0625  # V s/rad, V s²/rad, V


def engaged(rig: Rig, **change: float) -> JointServo:
    plain = {"gain": 0.0, "velocity_feedforward": K_V, "acceleration_feedforward": 0.0, "dither_V": 0.0, "null_bias_V": 0.0}
    servo = JointServo(rig.joints["rotary"], rig.servo["rotary"].model_copy(update={**plain, **change}), PERIOD_S)
    servo.measure(0.2)
    servo.engage()
    return servo


def command(servo: JointServo, rate: float) -> float:
    servo.measure(0.2)
    servo.step(0.2, rate, 0.0)
    return servo.command_V


@pytest.mark.parametrize("acceleration", [4.0, -4.0])
def test_a_ramp_of_the_rate_gets_volts_for_its_rate_and_its_acceleration(rig: Rig, acceleration: float) -> None:
    servo = engaged(rig, acceleration_feedforward=K_A)
    for cycle in range(1, 200):
        rate = acceleration * cycle * PERIOD_S
        assert command(servo, rate) == pytest.approx(K_V * rate + K_A * acceleration, rel=1e-9)
    assert command(servo, rate) == pytest.approx(K_V * rate), "at a steady rate"


def test_engaging_again_begins_at_rest(rig: Rig) -> None:
    """The rate of an earlier run is no acceleration of the next."""
    servo = engaged(rig, acceleration_feedforward=K_A)
    command(servo, 1.0)
    servo.release()
    servo.engage()
    assert command(servo, 0.0) == 0.0


def test_at_rest_the_dither_alternates_every_cycle_and_begins_upwards(rig: Rig) -> None:
    servo = engaged(rig, dither_V=DITHER_V)
    assert [command(servo, 0.0) for _ in range(6)] == [DITHER_V, -DITHER_V] * 3
    command(servo, 0.0)
    servo.release()
    servo.engage()
    assert [command(servo, 0.0) for _ in range(2)] == [DITHER_V, -DITHER_V]


def test_the_dither_is_added_to_the_feed_forward(rig: Rig) -> None:
    servo = engaged(rig, dither_V=DITHER_V)
    assert [command(servo, 0.5) for _ in range(2)] == pytest.approx([0.5 * K_V + DITHER_V, 0.5 * K_V - DITHER_V])
