"""Impulse shapers as pure functions: amplitudes and times. K̄ = exp(−πζ/√(1−ζ²)), T_d = 2π/ω_d.

Times in s, amplitudes without unit. Sources:
ZV, ZVD: N. Singer and W. Seering, J. Dynamic Systems, Measurement and Control 112, 1990.
EI, undamped form: W. Singhose, W. Seering and N. Singer, J. Mechanical Design 116, 1994.
Two-hump EI, undamped form: W. Singhose, L. Porter, T. Tuttle and N. Singer, J. Dynamic Systems, Measurement and Control 119, 1997.
Three-term: the paper's Eq 14 (D. Magee and W. Book's optimal arbitrary time-delay filter), its two exponents corrected to −2ζω_nT.
"""

from __future__ import annotations

from cmath import exp as cexp
from math import cos, exp, hypot, pi, sqrt

Impulses = tuple[tuple[float, ...], tuple[float, ...]]  # amplitudes (sum 1), times in s


def decay(damping_ratio: float) -> float:
    """K̄: what is left of an oscillation after half a period."""
    return exp(-pi * damping_ratio / sqrt(1.0 - damping_ratio**2))


def zv(omega_d: float, damping_ratio: float) -> Impulses:
    """Zero vibration: two impulses half a period apart."""
    k = decay(damping_ratio)
    return (1.0 / (1.0 + k), k / (1.0 + k)), (0.0, pi / omega_d)


def zvd(omega_d: float, damping_ratio: float) -> Impulses:
    """Zero vibration and derivative: three impulses, half a period apart; the three-term filter with T = T_d/2."""
    k = decay(damping_ratio)
    total = (1.0 + k) ** 2
    return (1.0 / total, 2.0 * k / total, k * k / total), (0.0, pi / omega_d, 2.0 * pi / omega_d)


def ei(omega_d: float, vibration: float) -> Impulses:
    """Extra-insensitive: `vibration` (e.g. 0.05) is tolerated at the centre frequency. Undamped form."""
    outer = (1.0 + vibration) / 4.0
    return (outer, (1.0 - vibration) / 2.0, outer), (0.0, pi / omega_d, 2.0 * pi / omega_d)


def two_hump_ei(omega_d: float, vibration: float) -> Impulses:
    """Two-hump extra-insensitive: four impulses, wider still. Undamped form."""
    v2 = vibration**2
    x = (v2 * (sqrt(1.0 - v2) + 1.0)) ** (1.0 / 3.0)
    outer = (3.0 * x * x + 2.0 * x + 3.0 * v2) / (16.0 * x)
    half = pi / omega_d
    return (outer, 0.5 - outer, 0.5 - outer, outer), (0.0, half, 2.0 * half, 3.0 * half)


def three_term(omega_d: float, damping_ratio: float, delay_s: float) -> Impulses:
    """c/Σc with c = [1, −2cos(ω_dT)e^{−ζω_nT}, e^{−2ζω_nT}] at 0, T, 2T: a zero at the mode for any T.

    Only sensible for 1.0 ≤ ω_d T ≤ 5.2 rad: Σc vanishes at 0 and 2π.
    """
    return three_term_amplitudes(omega_d, damping_ratio, delay_s), (0.0, delay_s, 2.0 * delay_s)


def three_term_amplitudes(omega_d: float, damping_ratio: float, delay_s: float) -> tuple[float, float, float]:
    """The three normalised weights alone (the loop needs them every cycle when they are scheduled)."""
    e = exp(-damping_ratio * omega_d / sqrt(1.0 - damping_ratio**2) * delay_s)
    c1 = -2.0 * cos(omega_d * delay_s) * e
    total = 1.0 + c1 + e * e
    return 1.0 / total, c1 / total, e * e / total


def transfer(impulses: Impulses, s: complex) -> complex:
    """F(s) = Σ A_i e^{−s t_i}."""
    return sum((a * cexp(-s * t) for a, t in zip(*impulses, strict=True)), 0j)


def residual_vibration(impulses: Impulses, omega_d: float, damping_ratio: float) -> float:
    """Vibration left at the last impulse, relative to that of one unit impulse: e^{−ζω_n t_n}·|Σ A_i e^{(ζω_n + jω_d) t_i}|."""
    sigma = damping_ratio * omega_d / sqrt(1.0 - damping_ratio**2)
    total = transfer(impulses, complex(-sigma, -omega_d))
    return exp(-sigma * impulses[1][-1]) * hypot(total.real, total.imag)
