"""The rotary gain that follows the extension: between its points, without a jump, from the measured extension, and what is refused."""

from __future__ import annotations

import json
from functools import cache
from itertools import pairwise
from math import degrees, nan, radians, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config.errors import ConfigError
from config.loading.load import find, rig_from_text
from config.loading.overrides import apply_overrides
from config.schema.rig import Rig
from servo_control.controller import Controller
from servo_control.servo.servo import JointServo
from servo_control.signals import Inputs, Mode

TEXT = find("rigs", "ornl_testbed").read_text(encoding="utf-8")
POINTS = "[{extension: 20 in, factor: 2.0}, {extension: 40 in, factor: 1.0}, {extension: 60 in, factor: 0.8}]"
PLAIN = ("servo.rotary.dither=0 V", "servo.rotary.oil_compensation=null", "end_point=null")
LAG = "servo.rotary.sections=[{zero: 80 rad/s, pole: 13.33 rad/s}]"
INCH, PERIOD_S = 0.0254, 0.001


@cache
def _rig(*changes: str, points: str = POINTS) -> Rig:
    return rig_from_text(apply_overrides(TEXT, [*PLAIN, f"servo.rotary.gain_schedule={points}", *changes]))


def _servo(rig: Rig) -> JointServo:
    servo = JointServo(rig.joints["rotary"], rig.servo["rotary"], PERIOD_S)
    servo.measure(0.0)
    servo.engage()
    return servo


@pytest.mark.parametrize(("inches", "factor"), [(12, 2.0), (20, 2.0), (25, 1.75), (40, 1.0), (50, 0.9), (60, 0.8)])
def test_the_gain_at_an_extension(inches: float, factor: float) -> None:
    servo = _servo(_rig())
    servo.follow_extension(inches * INCH)
    servo.step(radians(1.0), 0.0, 0.0)
    assert servo.command_V == pytest.approx(0.35 * factor)


def test_an_unknown_extension_leaves_the_gain() -> None:
    servo = _servo(_rig())
    servo.follow_extension(20 * INCH)
    servo.follow_extension(nan)
    servo.step(radians(1.0), 0.0, 0.0)
    assert servo.command_V == pytest.approx(0.70)


@settings(deadline=None)
@given(st.lists(st.floats(12, 60), min_size=2, max_size=40), st.floats(-2.0, 2.0))
def test_no_jump_with_a_memory_in_the_compensator(inches: list[float], error_deg: float) -> None:
    """A lag that has settled remembers 5/6 of the command: a new gain changes it by what passes the lag at once, no more."""
    servo = _servo(_rig(LAG))
    servo.follow_extension(40 * INCH)
    for _ in range(300):
        servo.step(radians(error_deg), 0.0, 0.0)
    passed = 13.33 / 80.0 * 1.05  # of the lag section at high frequency
    volts = [servo.command_V]
    factors = [1.0]
    for length in inches:
        servo.follow_extension(length * INCH)
        servo.step(radians(error_deg), 0.0, 0.0)
        volts.append(servo.command_V)
        factors.append(2.0 - (length - 20) / 20 if 20 < length < 40 else 2.0 if length <= 20 else 1.0 - 0.2 * (length - 40) / 20)
    settling = 0.35 * 2.0 * abs(error_deg) * 13.33 * PERIOD_S  # towards the new gain, with the time constant of the lag
    for (a, b), (before, after) in zip(pairwise(volts), pairwise(factors), strict=True):
        assert abs(b - a) <= passed * 0.35 * abs(error_deg) * abs(after - before) + settling


def _inputs(n: int) -> Inputs:
    return Inputs(n, Mode.HOLDING, 0, (0.1 + 0.002 * sin(0.01 * n), 0.9 + 0.3 * sin(0.004 * n)), nan, nan)


def test_the_controller_takes_the_measured_extension_and_continues_bit_for_bit() -> None:
    rig = _rig(LAG)
    controller = Controller(rig)
    for n in range(300):
        controller.step(_inputs(n))
    copy = Controller(rig)
    copy.restore(json.loads(json.dumps(controller.snapshot(), allow_nan=False)))
    for n in range(300, 600):
        assert controller.step(_inputs(n)) == copy.step(_inputs(n))
    plain = Controller(_rig())
    for extension, factor in ((20 * INCH, 2.0), (40 * INCH, 1.0)):
        plain.step(Inputs(0, Mode.DISARMED, 0, (0.0, extension), nan, nan))
        plain.step(Inputs(1, Mode.HOLDING, 0, (0.0, extension), nan, nan))
        out = plain.step(Inputs(2, Mode.HOLDING, 0, (radians(-1.0), extension), nan, nan))
        assert out.joints[0].command_V == pytest.approx(0.35 * factor)


@pytest.mark.parametrize(
    ("points", "text"),
    [
        ("[{extension: 40 in, factor: 1}, {extension: 20 in, factor: 1}]", "extensions must rise"),
        ("[{extension: 40 in, factor: 0}]", "factor"),
        ("[{extension: 40 deg, factor: 1}]", "extension"),
    ],
)
def test_what_cannot_be_is_refused(points: str, text: str) -> None:
    with pytest.raises(ConfigError, match="gain_schedule") as caught:
        _rig(points=points)
    assert text in str(caught.value)


def test_a_schedule_needs_an_extension() -> None:
    axis = find("rigs", "rotary_actuator").read_text(encoding="utf-8")
    with pytest.raises(ConfigError, match="whose position is the extension"):
        rig_from_text(apply_overrides(axis, ["servo.shaft.gain_schedule=[{extension: 1 m, factor: 1}]"]))


def test_without_a_schedule_the_gain_is_one() -> None:
    servo = _servo(_rig(points="[]"))
    servo.follow_extension(20 * INCH)
    servo.step(0.01, 0.0, 0.0)
    assert servo.command_V == pytest.approx(0.35 * degrees(0.01))
