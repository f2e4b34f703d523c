"""The notch in the rotary error: its response against the closed form, where it acts, that it forgets and goes on bit for bit."""

from __future__ import annotations

import json
from math import nan, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config.errors import ConfigError
from config.loading.load import find, rig_from_text
from config.loading.overrides import apply_overrides
from config.schema.rig import LinkMode
from config.schema.servo import LinkNotchRange
from servo_control.controller import Controller
from servo_control.link.link_mode import LinkFrequency
from servo_control.servo.link_notch import LinkNotch
from servo_control.signals import Inputs, Mode

TEXT = find("rigs", "ornl_testbed").read_text(encoding="utf-8")
EMPTY = LinkMode(bending_stiffness=3556.75, mass_per_length=2.545698, payload=0.0, damping_ratio=0.005)
PERIOD_S, TRAVEL = 0.001, (0.3048, 1.524)
INCH = 0.0254


def _notch(extension_m: float) -> LinkNotch:
    notch = LinkNotch(LinkNotchRange(), EMPTY, TRAVEL, PERIOD_S)
    notch.follow(extension_m)
    return notch


def _response(notch: LinkNotch, frequency_Hz: float) -> complex:
    """Of the sampled filter, by driving it with e^{jωnT} as two real signals until it is steady."""
    angle = 2.0 * pi * frequency_Hz * PERIOD_S * np.arange(4000)
    parts = []
    for signal in (np.cos(angle), np.sin(angle)):
        notch.reset()
        parts.append(np.array([notch.step(float(x)) for x in signal]))
    return complex((parts[0][-1] + 1j * parts[1][-1]) * np.exp(-1j * angle[-1]))


@pytest.mark.parametrize("inches", [30.0, 42.0, 44.0])
@pytest.mark.parametrize("share", [0.13, 0.8, 1.0, 1.25])
def test_response_is_the_closed_form(inches: float, share: float) -> None:
    """1 − s · 2ωp/(p + ω)² with the trapezoidal rule's p = j tan(πfT)/tan(ωT/2) · ω; s = 1 from 18 Hz on, half of it at 17 Hz (44 in)."""
    own_Hz = LinkFrequency(EMPTY).frequency_Hz(inches * INCH)
    full = min(max((own_Hz - 16.0) / 2.0, 0.0), 1.0)
    assert full < 1.0 if inches == 44.0 else full == 1.0
    p = 1j * np.tan(pi * share * own_Hz * PERIOD_S) / np.tan(pi * own_Hz * PERIOD_S)
    assert _response(_notch(inches * INCH), share * own_Hz) == pytest.approx(1.0 - full * 2.0 * p / (1.0 + p) ** 2, abs=1e-6)


def test_the_link_sees_no_noise_and_the_servo_little_lag() -> None:
    """18 Hz and a tenth off: 0, a tenth. At the servo's crossover of 2.4 Hz the phase is 2 arctan(2.4/18.3) behind."""
    notch = _notch(42.4 * INCH)
    own_Hz = LinkFrequency(EMPTY).frequency_Hz(42.4 * INCH)
    assert abs(_response(notch, own_Hz)) < 1e-6
    assert max(abs(_response(notch, share * own_Hz)) for share in (0.9, 1.1)) < 0.11
    assert np.angle(_response(notch, 2.4)) == pytest.approx(-2.0 * np.arctan(2.4 / own_Hz), rel=0.01)


def test_a_slow_link_has_none_to_the_last_bit() -> None:
    notch = _notch(55 * INCH)
    errors = [1e-3 * sin(0.1 * n) for n in range(200)]
    assert [notch.step(error) for error in errors] == errors


def test_what_it_remembers_is_gone_when_the_link_was_slow_meanwhile() -> None:
    notch = _notch(30 * INCH)
    for _ in range(20):
        notch.step(0.01)
    notch.follow(55 * INCH)
    notch.step(0.01)
    notch.follow(30 * INCH)
    assert notch.snapshot() == _notch(30 * INCH).snapshot()


def test_an_extension_that_is_lost_or_impossible() -> None:
    """Lost: the frequency stays. Beyond the travel: that of its end."""
    notch, same = _notch(30 * INCH), _notch(30 * INCH)
    notch.follow(nan)
    assert notch.step(0.01) == same.step(0.01)
    far, end = _notch(-5.0), _notch(TRAVEL[0])
    assert far.step(0.01) == end.step(0.01)


@settings(deadline=None)
@given(st.lists(st.floats(-1.0, 3.0), min_size=2, max_size=60))
def test_it_stays_bounded_however_the_extension_jumps(extensions: list[float]) -> None:
    """Trapezoidal integrators lose energy at every frequency: the state's norm never exceeds what bounded errors can put in."""
    notch = _notch(30 * INCH)
    for n in range(2000):
        notch.follow(extensions[n % len(extensions)])
        assert abs(notch.step(0.01 * (-1) ** (n // 7))) < 0.1


def _inputs(n: int) -> Inputs:
    return Inputs(n, Mode.HOLDING, 0, (0.1 + 0.002 * sin(0.01 * n), 0.4 + 0.08 * sin(0.004 * n)), nan, nan)


def test_the_controller_continues_bit_for_bit() -> None:
    """12.6 to 18.9 in with 45 lb: where the shipped notch comes in and goes out."""
    rig = rig_from_text(TEXT)
    controller, copy, without = (
        Controller(each) for each in (rig, rig, rig_from_text(apply_overrides(TEXT, ["servo.rotary.link_notch=null"])))
    )
    for n in range(300):
        controller.step(_inputs(n))
        without.step(_inputs(n))
    copy.restore(json.loads(json.dumps(controller.snapshot(), allow_nan=False)))
    outputs = [controller.step(_inputs(n)) for n in range(300, 1500)]
    assert outputs == [copy.step(_inputs(n)) for n in range(300, 1500)]
    assert outputs != [without.step(_inputs(n)) for n in range(300, 1500)]


@pytest.mark.parametrize(
    ("rig", "change", "text"),
    [
        ("ornl_testbed", "servo.rotary.link_notch={none_below: 18 Hz, full_above: 16 Hz}", "must be above none_below"),
        ("ornl_testbed", "servo.prismatic.link_notch={}", "link_notch"),
        ("rotary_actuator", "servo.shaft.link_notch={none_below: 12 Hz}", "whose position is the extension"),
    ],
)
def test_what_cannot_be_is_refused(rig: str, change: str, text: str) -> None:
    with pytest.raises(ConfigError, match=text):
        rig_from_text(apply_overrides(find("rigs", rig).read_text(encoding="utf-8"), [change]))
