"""What python-control does for tuning, against closed forms: margins, holds, crossings; and who must not load it."""

from __future__ import annotations

import subprocess
import sys
from functools import reduce
from math import degrees, exp, log10, pi, radians, sqrt

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.schema.rig import Rig
from tuning.limit_cycles.describing_function import FrictionCompliance
from tuning.limit_cycles.limit_cycles import predict_limit_cycles
from tuning.linear.closed_loop import Servo, modes, sampled_loop
from tuning.linear.family import compensator_response, sampled_compensator, sampled_plant
from tuning.linear.linear_arm import linear_arm
from tuning.linear.margins import margins
from tuning.transfer import EQ4, lag_lead

SECTIONS = ((40.0, 400.0), (8.0, 2.0))


@given(gain=st.floats(2.0, 60.0), delay_s=st.floats(0.004, 0.02))
def test_margins_of_an_integrator_with_dead_time(gain: float, delay_s: float) -> None:
    """K e^{−sT}/s: crossover K, phase margin 90° − KT, gain margin π/(2KT)."""
    if gain * delay_s > 1.2:  # hardly stable: nothing to tell of margins
        return
    found = margins(lambda w: gain * np.exp(-1j * w * delay_s) / (1j * w))
    assert found.crossover_Hz == pytest.approx(gain / (2 * pi), rel=1e-7)
    assert found.phase_margin_deg == pytest.approx(90.0 - degrees(gain * delay_s), abs=1e-5)
    assert found.gain_margin_dB == pytest.approx(20 * log10(pi / (2 * gain * delay_s)), abs=1e-5)


@pytest.mark.parametrize("pace", [0.1, 1.0, 30.0])
def test_margins_of_a_faster_joint_are_the_same_at_higher_frequencies(pace: float) -> None:
    """K e^{−sT}/s with K times and T over the pace: π/(2KT) stays, 8.3 Hz times the pace is where it crosses −180°."""
    found = margins(lambda w: pace * 20.0 * np.exp(-1j * w * 0.03 / pace) / (1j * w), pace)
    assert found.gain_margin_dB == pytest.approx(20 * log10(pi / (2 * 20.0 * 0.03)), abs=1e-5)
    assert found.crossover_Hz == pytest.approx(pace * 20.0 / (2 * pi), rel=1e-7)


@pytest.mark.parametrize("damping", [0.1, 0.3, 0.7])
def test_margins_of_a_second_order_loop(damping: float) -> None:
    """ω²/(s (s + 2ζω)), e.g. Ogata: phase margin atan(2ζ/√(√(1 + 4ζ⁴) − 2ζ²)), largest |S|² = (1 + x)/x with x from dM²/dω = 0."""
    omega = 20.0
    found = margins(lambda w: omega**2 / (1j * w * (1j * w + 2 * damping * omega)))
    assert radians(found.phase_margin_deg) == pytest.approx(
        np.arctan(2 * damping / sqrt(sqrt(1 + 4 * damping**4) - 2 * damping**2)), rel=1e-7
    )
    assert found.gain_margin_dB == float("inf")
    # |S|² over y = (w/ω)² is y (y + 4ζ²) / ((1 − y)² + 4ζ² y); its derivative vanishes at y = (1 + √(1 + 8ζ²))/2
    y = (1 + sqrt(1 + 8 * damping**2)) / 2
    assert found.sensitivity_peak == pytest.approx(sqrt(y * (y + 4 * damping**2) / ((1 - y) ** 2 + 4 * damping**2 * y)), rel=1e-6)


@pytest.mark.parametrize("times", [0.5, 1.5, 4.0])
def test_margins_of_a_loop_beyond_its_limit_are_below_zero(times: float) -> None:
    """K/(s (s² + a s + b)) is stable up to K = a b (Routh), whatever the phase at its crossover."""
    found = margins(lambda w: times * 140.0 * 6150.0 / (1j * w * ((1j * w) ** 2 + 140.0 * 1j * w + 6150.0)))
    assert found.gain_margin_dB == pytest.approx(-20 * log10(times), abs=1e-4)
    assert (found.phase_margin_deg > 0.0) == (times < 1.0)
    x = max(np.roots([1.0, 140.0**2 - 2 * 6150.0, 6150.0**2, -((times * 140.0 * 6150.0) ** 2)]).real)  # ω² where |L| = 1
    below = degrees(np.arctan2(140.0 * sqrt(x), 6150.0 - x)) - 90.0  # beyond −180°
    assert found.phase_margin_deg == pytest.approx(-below, abs=1e-4)


@pytest.mark.parametrize("times", [0.7, 1.5, 20.0, 60.0])
def test_a_loop_that_is_stable_between_two_gains_only(times: float) -> None:
    """K (s + 2)²/(s³ (s/200 + 1)²): its closed loop's poles are asked between which gains."""
    loop = control.tf(np.poly([-2.0, -2.0]), np.polymul([1.0, 0.0, 0.0, 0.0], np.polymul([1 / 200, 1], [1 / 200, 1])))

    def stable(gain: float) -> bool:
        return bool((control.feedback(gain * loop, 1).poles().real < 0.0).all())

    found = margins(lambda w: times * loop(1j * w))
    assert (found.phase_margin_deg > 0.0) == (found.gain_margin_dB > 0.0) == stable(times)
    if found.gain_margin_dB > -np.inf:
        edge = times * 10 ** (found.gain_margin_dB / 20)
        assert (stable(0.999 * edge), stable(1.001 * edge)) == (True, False)


def test_the_sign_of_margins_is_that_of_the_poles() -> None:
    """Sixty random loops with up to two integrators, resonances and zeros, against the poles of their closed loops."""
    random = np.random.default_rng(7)
    seen = []
    for _ in range(60):
        loop = _random_loop(random)
        closed = control.feedback(loop, 1).poles().real
        if abs(closed).min() < 0.01:  # on the edge, to rounding
            continue
        found = margins(lambda w, loop=loop: loop(1j * w))
        seen.append(bool(closed.max() < 0.0))
        assert [found.phase_margin_deg > 0.0, found.gain_margin_dB > 0.0] == [seen[-1]] * 2
    assert min(seen.count(True), seen.count(False)) > 15


def _random_loop(random: np.random.Generator) -> control.TransferFunction:
    """Of relative degree 1 at least; its gain is 1 somewhere between 0.3 and 10 Hz."""

    def corner(low: float, high: float) -> float:
        return float(2 * pi * 10 ** random.uniform(low, high))

    poles = [[1.0, 0.0]] * int(random.integers(0, 3))
    for _ in range(random.integers(2, 4)):
        w = corner(-0.5, 1.3)
        poles.append([1.0, 2 * random.uniform(0.05, 1.0) * w, w * w] if random.random() < 0.5 else [1.0, w])
    bottom = reduce(np.polymul, poles, np.ones(1))
    top = np.atleast_1d(np.poly([-corner(-1.0, 1.3) for _ in range(random.integers(0, 2))]))
    at = 1j * corner(-0.5, 1.0)
    return control.tf(top * abs(np.polyval(bottom, at) / np.polyval(top, at)), bottom)


def test_a_loop_that_never_crosses() -> None:
    """Half at all frequencies: no crossover, no margin, |S| = 2/3."""
    found = margins(lambda w: np.full(w.shape, 0.5 + 0j))
    assert (found.crossover_Hz, found.phase_margin_deg, found.gain_margin_dB) == (0.0, float("inf"), float("inf"))
    assert found.sensitivity_peak == pytest.approx(2 / 3)


def test_integrator_with_lag_behind_a_hold() -> None:
    """k/(s (s + a)) behind a hold (Åström and Wittenmark, table 2.1): b₁ = k(aT − 1 + e^{−aT})/a²,
    b₂ = k(1 − e^{−aT} − aT e^{−aT})/a²."""
    k, a, period_s = 30.0, 12.0, 0.01
    pole = exp(-a * period_s)
    first, second = k * (a * period_s - 1 + pole) / a**2, k * (1 - pole - a * period_s * pole) / a**2
    z = np.exp(1j * np.array([0.5, 5.0, 50.0]) * period_s)
    expected = (first * z + second) / ((z - 1) * (z - pole))
    for delay in (0, 1, 3):
        found = sampled_plant(control.tf([k], [1.0, a, 0.0]), period_s, delay)
        assert found(z) == pytest.approx(expected * z**-delay, rel=1e-9)


def test_sampled_compensator_is_tustins_rule() -> None:
    """C(s) at s = (2/T)(z − 1)/(z + 1), whatever the frequency."""
    servo, period_s = Servo(3.0, SECTIONS), 0.001
    z = np.exp(1j * 2 * pi * np.array([0.1, 1.0, 10.0, 100.0]) * period_s)
    s = 2 / period_s * (z - 1) / (z + 1)
    assert sampled_compensator(servo, period_s)(z) == pytest.approx(lag_lead(3.0, SECTIONS)(s), rel=1e-10)


def test_lag_lead_at_the_ends() -> None:
    """C(0) = gain, C(∞) = gain · Π pole/zero; in between what the search's own formula says."""
    found = lag_lead(3.0, SECTIONS)
    assert complex(found(0.0)) == pytest.approx(3.0)
    assert complex(found(1e9j)) == pytest.approx(3.0 * 10 / 4, rel=1e-6)
    omega = np.geomspace(0.01, 1000.0, 20)
    assert compensator_response(Servo(3.0, SECTIONS), omega) == pytest.approx(found(1j * omega), rel=1e-12)


@pytest.mark.parametrize(("gain", "ratio"), [(0.8, 1.1), (2.0, 1.2), (3.0, 1.0)])
def test_at_a_crossing_the_loop_goes_on_for_ever(gain: float, ratio: float) -> None:
    """Harmonic balance, from the definition: L(jω) · first harmonic of the element's output = −input."""
    element = FrictionCompliance.of_ratio(ratio)
    found = predict_limit_cycles(gain * EQ4, element)
    assert found
    for cycle in found:
        s = 2j * pi * cycle.frequency_Hz
        loop = gain * 240810.0 / (s * (s * s + 140.0 * s + 6150.0))
        assert loop * element.harmonics(cycle.amplitude, 1, 1 << 18)[0] == pytest.approx(-1.0, abs=2e-3)


@pytest.mark.slow
def test_nothing_that_runs_or_starts_a_run_loads_it() -> None:
    """python-control brings matplotlib: neither the loop, nor `start --wait`, nor the gap finder may pay for it."""
    modules = (
        "servo_control.controller, daemon.loop.control_loop, tuning.shaper_choice.shaped_moves, tuning.identification.record_file, gap.find"
    )
    asked = f"import sys, {modules}; print('control' in sys.modules)"
    ran = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "False"


@pytest.mark.parametrize(("inches", "roll_off_Hz", "delay"), [(20.0, 8.0, 0), (40.0, 8.0, 1), (60.0, 0.0, 2)])
def test_sampled_loop_as_python_control_puts_it_together(rig: Rig, inches: float, roll_off_Hz: float, delay: int) -> None:
    """The design's matrix of one period has the modes of plant, tip filter and lag-lead joined by the library (0 Hz: no filter)."""
    period_s, servo = 0.001, Servo(20.0, SECTIONS, 0.6, roll_off_Hz, tip_lead=(0.9, 0.2))
    arm = linear_arm(rig, inches * 0.0254)
    keep = exp(-2 * pi * roll_off_Hz * period_s) if roll_off_Hz else 0.0
    low_pass = control.tf([1.0 - keep, 0.0], [1.0, -keep], period_s)
    kept, lead = servo.tip_lead
    tip = servo.tip_gain / arm.extension_m * ((kept - lead) * low_pass + lead)
    error = control.ss([], [], [], [[-1.0, 1.0]], period_s) * control.append(control.ss([], [], [], 1.0, period_s), control.ss(tip))
    late = control.ss(control.tf([1.0], [1.0] + delay * [0.0], period_s))
    joined = control.feedback(control.c2d(arm.system(), period_s), late * control.ss(sampled_compensator(servo, period_s)) * error, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        frequency, damping, _ = joined.damp()
    slow = frequency < 2 * pi * 200.0  # a delay has poles at z = 0, which have no frequency
    own = modes(sampled_loop(arm, servo, period_s, delay), period_s)
    below = own.frequency_Hz < 200.0
    assert own.damping_ratio[below].min() == pytest.approx(damping[slow].min(), abs=1e-9)
    assert sorted({round(f, 5) for f in own.frequency_Hz[below]}) == sorted({round(w / (2 * pi), 5) for w in frequency[slow]})
