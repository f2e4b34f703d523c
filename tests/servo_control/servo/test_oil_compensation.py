"""The feed-forward that follows the oil's temperature: its table, its memory, and the servo around it."""

from __future__ import annotations

import json
from itertools import pairwise
from math import nan, radians

import pytest

from config.errors import ConfigError
from config.loading.load import find, rig_from_text
from config.loading.overrides import apply_overrides
from config.schema.rig import Rig
from servo_control.controller import Controller
from servo_control.servo.oil_compensation import OilCompensation, temperature_signals
from servo_control.signals import Inputs, Mode

TEXT = find("rigs", "ornl_testbed").read_text(encoding="utf-8")
POINTS = (
    "{temperature: 20 degC, velocity_factor: 1.2, friction: -0.02 V, bias: 0.1 V}, "
    "{temperature: 60 degC, velocity_factor: 1.0, friction: 0.06 V, bias: -0.1 V}"
)


def _rig(source: str = "rotary.return_temperature", points: str = POINTS) -> Rig:
    override = f"servo.rotary.oil_compensation={{source: {source}, filter: 0.1 s, friction_rate: 1 deg/s, points: [{points}]}}"
    return rig_from_text(apply_overrides(TEXT, [override, "servo.rotary.dither=0 V"]))


def _table() -> OilCompensation:
    servo = _rig().servo["rotary"]
    assert servo.oil_compensation is not None
    return OilCompensation(servo.oil_compensation, servo.velocity_feedforward, 0.001)


def test_between_two_points_on_a_straight_line_and_constant_beyond() -> None:
    feedforward = _rig().servo["rotary"].velocity_feedforward
    for measured, factor, friction, bias in ((30.0, 1.15, 0.0, 0.05), (5.0, 1.2, -0.02, 0.1), (90.0, 1.0, 0.06, -0.1)):
        table = _table()
        table.measure(measured)
        assert table.volts(0.3) == pytest.approx((factor - 1.0) * feedforward * 0.3 + friction, abs=1e-12)
        assert table.volts(-0.3) == pytest.approx(-table.volts(0.3), abs=1e-12)
        assert table.bias_V == pytest.approx(bias)


def test_each_direction_has_its_own_factor_and_nothing_jumps_at_rest() -> None:
    """20 °C: 0.97 forth and 1.12 back; 60 °C: 0.98, and back the same, since nothing else is said."""
    points = (
        "{temperature: 20 degC, velocity_factor: 0.97, velocity_factor_back: 1.12, friction: 0.05 V}, "
        "{temperature: 60 degC, velocity_factor: 0.98, friction: 0.05 V}"
    )
    servo = _rig(points=points).servo["rotary"]
    assert servo.oil_compensation is not None
    feedforward = servo.velocity_feedforward
    for measured, forth, back in ((20.0, 0.97, 1.12), (40.0, 0.975, 1.05), (60.0, 0.98, 0.98)):
        table = OilCompensation(servo.oil_compensation, feedforward, 0.001)
        table.measure(measured)
        assert table.volts(0.3) == pytest.approx((forth - 1.0) * feedforward * 0.3 + 0.05, abs=1e-12)
        assert table.volts(-0.3) == pytest.approx((1.0 - back) * feedforward * 0.3 - 0.05, abs=1e-12)
        assert abs(table.volts(1e-9) - table.volts(-1e-9)) < 1e-8


def test_at_rest_friction_is_not_pushed_against() -> None:
    table = _table()
    table.measure(60.0)
    assert table.volts(0.0) == 0.0


def test_a_feedback_gets_its_share_of_the_friction_and_gives_way_to_the_reference() -> None:
    """0.06 V of friction, of which 0.6 is lent; none at 1 deg/s, half of it at half that rate."""
    table = _table()
    table.measure(60.0)
    assert table.volts(0.0, 0.2) == pytest.approx(0.2 * 0.06)
    assert table.volts(0.0, 1.0) == pytest.approx(0.6 * 0.06)
    assert table.volts(0.0, -1.0) == pytest.approx(-0.6 * 0.06)
    half, full = radians(0.5), radians(1.0)
    assert table.volts(half, -1.0) - table.volts(half) == pytest.approx(-0.5 * 0.6 * 0.06)
    assert table.volts(full, -1.0) == table.volts(full)


def test_a_feedback_is_lent_nothing_of_a_negative_friction() -> None:
    """-0.02 V at 20 °C corrects the feed-forward; lent to a feedback it would push the wrong way."""
    table = _table()
    table.measure(20.0)
    assert (table.volts(0.0, 1.0), table.volts(0.0, -1.0)) == (0.0, 0.0)


def test_nothing_before_the_first_sample_and_the_last_one_is_kept_when_samples_are_lost() -> None:
    table = _table()
    table.measure(nan)
    assert (table.volts(0.3), table.bias_V) == (0.0, 0.0)
    table.measure(60.0)
    before = table.volts(0.3)
    table.measure(nan)
    assert table.volts(0.3) == before


def test_the_temperature_is_low_passed() -> None:
    """One time constant after a step of 40 K, 63.2 % of it."""
    table = _table()
    table.measure(20.0)
    for _ in range(100):
        table.measure(60.0)
    assert table.temperature_C == pytest.approx(20.0 + 40.0 * 0.63212, abs=0.01)


def _volts(rig: Rig, temperature_C: float, cycles: int = 700) -> list[float]:
    controller = Controller(rig)
    rows = [Inputs(n, Mode.HOLDING, 0, (0.1, 0.9), nan, nan, (temperature_C, nan)) for n in range(cycles)]
    return [controller.step(row).joints[0].command_V for row in rows]


def test_the_bias_comes_in_smoothly_after_engaging() -> None:
    volts = _volts(_rig(), 20.0)
    assert volts[-1] == pytest.approx(0.1)
    assert max(abs(b - a) for a, b in pairwise(volts)) < 0.001


def test_a_snapshot_continues_bit_for_bit() -> None:
    rig = _rig()
    controller, rows = Controller(rig), [Inputs(n, Mode.HOLDING, 0, (0.1, 0.9), nan, nan, (20.0 + 0.1 * n, nan)) for n in range(400)]
    for row in rows[:200]:
        controller.step(row)
    copy = Controller(rig)
    copy.restore(json.loads(json.dumps(controller.snapshot())))
    for row in rows[200:]:
        assert controller.step(row).joints[0].command_V.hex() == copy.step(row).joints[0].command_V.hex()


def test_which_signals_are_asked_for() -> None:
    assert temperature_signals(_rig()) == ("rotary.return_temperature", "prismatic.return_temperature")
    without = apply_overrides(TEXT, ["servo.rotary.oil_compensation=null", "end_point=null"])
    assert temperature_signals(rig_from_text(without)) == (None, "prismatic.return_temperature")


@pytest.mark.parametrize(
    ("rig", "text"),
    [
        (("rotary.supply_temperatur", POINTS), "there is no temperature signal 'rotary.supply_temperatur': nearest is"),
        (("rotary.return_temperature", "{temperature: 40 degC}, {temperature: 40 degC}"), "temperatures must rise"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(rig: tuple[str, str], text: str) -> None:
    with pytest.raises(ConfigError, match="oil_compensation") as caught:
        _rig(*rig)
    assert text in str(caught.value)
