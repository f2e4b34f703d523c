"""Row 19 and table 7.1: corrected Eq 14, test vectors, and robustness from the vibration-residual formula, evaluated here."""

from __future__ import annotations

from math import log10, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from servo_control.shapers import impulses
from servo_control.shapers.impulses import Impulses

OMEGA = 2 * pi


@given(st.floats(0.5, 30), st.floats(0.0, 0.2), st.floats(1.0, 5.2))
def test_three_term_has_a_zero_at_the_mode_for_any_delay(frequency_Hz: float, zeta: float, angle: float) -> None:
    omega_d = 2 * pi * frequency_Hz * sqrt(1 - zeta**2)
    filter_ = impulses.three_term(omega_d, zeta, angle / omega_d)
    pole = complex(-zeta * 2 * pi * frequency_Hz, omega_d)
    assert abs(impulses.transfer(filter_, pole)) <= 1e-12
    assert impulses.transfer(filter_, 0j) == pytest.approx(1.0, abs=1e-12)


def test_printed_vectors() -> None:
    """f = 4 Hz, ζ = 0.02."""
    omega_d = 2 * pi * 4 * sqrt(1 - 0.02**2)
    assert impulses.three_term(omega_d, 0.02, 0.07)[0] == pytest.approx((0.43607463, 0.15748318, 0.40644219), abs=1e-8)
    amplitudes, times = impulses.zv(omega_d, 0.02)
    assert amplitudes == pytest.approx((0.51570594, 0.48429406), abs=1e-8)
    assert times[1] == pytest.approx(0.12502501, abs=1e-8)
    assert impulses.zvd(omega_d, 0.02)[0] == pytest.approx((0.26595261, 0.49950665, 0.23454074), abs=1e-8)


def test_three_term_with_half_a_period_is_zvd() -> None:
    omega_d = 2 * pi * 3.2
    assert impulses.three_term(omega_d, 0.01, pi / omega_d)[0] == pytest.approx(impulses.zvd(omega_d, 0.01)[0], abs=1e-15)


def _residual(filter_: Impulses, omega: float) -> float:
    """Undamped residual |Σ A e^{−jωt}|."""
    a, t = np.array(filter_[0]), np.array(filter_[1])
    return float(abs((a * np.exp(-1j * omega * t)).sum()))


def _width(filter_: Impulses, level: float = 0.05) -> float:
    """Relative width of the band about the design frequency in which the residual stays below `level`."""
    step = 1e-3
    edges = []
    for sign in (1, -1):
        ratio = 1.0
        while _residual(filter_, OMEGA * (ratio + sign * step)) <= level * (1 + 1e-9):
            ratio += sign * step
        edges.append(brentq(lambda r: _residual(filter_, OMEGA * r) - level * (1 + 1e-9), ratio, ratio + sign * step))
    return edges[0] - edges[1]


WIDTHS = [
    ("ZV", impulses.zv(OMEGA, 0), 0.064),
    ("ZVD", impulses.zvd(OMEGA, 0), 0.288),
    ("EI", impulses.ei(OMEGA, 0.05), 0.400),
    ("two-hump EI", impulses.two_hump_ei(OMEGA, 0.05), 0.725),
    ("three-term 0.25", impulses.three_term(OMEGA, 0, 0.25), 0.064),
    ("three-term 0.35", impulses.three_term(OMEGA, 0, 0.35), 0.090),
    ("three-term 0.15", impulses.three_term(OMEGA, 0, 0.15), 0.054),
]


@pytest.mark.parametrize(("name", "filter_", "width"), WIDTHS)
def test_width_of_the_5_percent_band(name: str, filter_: Impulses, width: float) -> None:
    assert _width(filter_) == pytest.approx(width, abs=0.0011)


LEVELS = [
    ("ZV", impulses.zv(OMEGA, 0), -22.1, -16.1),
    ("ZVD", impulses.zvd(OMEGA, 0), -44.2, -32.2),
    ("EI", impulses.ei(OMEGA, 0.05), -27.2, -32.3),
    ("two-hump EI", impulses.two_hump_ei(OMEGA, 0.05), -33.5, -28.3),
    ("three-term 0.35", impulses.three_term(OMEGA, 0, 0.35), -25.0, -19.0),
]


@pytest.mark.parametrize(("name", "filter_", "at_5", "at_10"), LEVELS)
def test_residual_at_wrong_frequencies(name: str, filter_: Impulses, at_5: float, at_10: float) -> None:
    """The worse of + and −; printed to 0.1 dB, the three-term row to 1 dB."""
    for error, expected in ((0.05, at_5), (0.10, at_10)):
        worst = max(20 * log10(_residual(filter_, OMEGA * (1 + sign * error))) for sign in (1, -1))
        assert worst == pytest.approx(expected, abs=0.06 if name != "three-term 0.35" else 0.6)


@given(st.floats(0.0, 0.1), st.floats(0.7, 1.3))
def test_residual_formula_is_the_response_of_an_oscillator(zeta: float, ratio: float) -> None:
    """Against the superposed impulse responses of a damped oscillator, evaluated at the last impulse."""
    filter_ = impulses.zvd(OMEGA, zeta)
    omega_d = OMEGA * ratio
    sigma = zeta * omega_d / sqrt(1 - zeta**2)
    end = filter_[1][-1]
    modes = [a * np.exp((-sigma + 1j * omega_d) * (end - t)) for a, t in zip(*filter_, strict=True)]
    assert impulses.residual_vibration(filter_, omega_d, zeta) == pytest.approx(abs(sum(modes)), abs=1e-12)
