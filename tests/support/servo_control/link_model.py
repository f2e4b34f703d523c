"""Judge of the shapers, independent of control/: the clamped link with two shapes and a tip mass on a prescribed joint motion.

    M η'' + [m L² x̂ + M_p L t] θ'' + m L'' Ĉ η + 2 m L' Ĉ η' + 2 L' θ' (m L p̂ + M_p t) − θ'² M η − (m L'²/L) D̂ η + (EI/L³) K̂ η + C η' = 0

with M = m L M̂ + M_p t tᵀ, C = (2ζ/ω₁)(EI/L³) K̂ and the shapes ψ₁ = (3ξ² − ξ³)/2, ψ₂ = 3ξ² − 5ξ³ + 2ξ⁴ (η₁ is the tip deflection).
Integrated with scipy's DOP853 on joint motions given every millisecond.
"""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

EI, MASS_PER_LENGTH, PAYLOAD, ZETA = 3556.75, 2.545698, 45 * 0.45359237, 0.005
PERIOD_S = 0.001
Array = NDArray[np.float64]


def frequency_Hz(extension: float) -> float:
    """First frequency, one shape (0.02 % high)."""
    return sqrt(3 * EI / (extension**3 * (PAYLOAD + 33 / 140 * MASS_PER_LENGTH * extension))) / (2 * pi)


def tip_motion(theta: Array, theta_rate: Array, length: Array, length_rate: Array) -> tuple[Array, Array]:
    """Tip deflection w (m) and its rate at the samples (1 kHz) of a joint motion that starts at rest."""
    theta_acc, length_acc = np.gradient(theta_rate, PERIOD_S), np.gradient(length_rate, PERIOD_S)
    table = np.column_stack([theta_rate, theta_acc, length, length_rate, length_acc])
    rows, slopes = table.tolist(), np.vstack([np.diff(table, axis=0), np.zeros(5)]).tolist()
    last = len(rows) - 1

    def slope(t: float, state: Array) -> list[float]:
        i = min(int(t / PERIOD_S), last)
        u = t / PERIOD_S - i
        values = [a + u * b for a, b in zip(rows[i], slopes[i], strict=True)]
        return link_slope(state.tolist(), *values)

    times = np.arange(len(rows)) * PERIOD_S
    solution = solve_ivp(slope, (0.0, times[-1]), np.zeros(4), "DOP853", t_eval=times, max_step=0.002, rtol=1e-6, atol=1e-11)
    return solution.y[0], solution.y[2]


def link_slope(state: list[float], q: float, qa: float, L: float, Lr: float, La: float) -> list[float]:
    """d/dt of (η₁, η₂, η̇₁, η̇₂)."""
    n1, n2, v1, v2 = state
    m, p = MASS_PER_LENGTH, PAYLOAD
    m11, m12, m22 = m * L * 33 / 140 + p, m * L * 17 / 280, m * L * 19 / 630
    stiffness = EI / L**3
    damping = 2 * ZETA / (2 * pi * frequency_Hz(L)) * stiffness
    c1, c2 = 33 / 280 * n1 - n2 / 140, 19 / 280 * n1 + 19 / 1260 * n2
    d1, d2 = 33 / 280 * v1 - v2 / 140, 19 / 280 * v1 + 19 / 1260 * v2
    e1, e2 = 6 / 35 * n1 + n2 / 14, n1 / 14 + 26 / 315 * n2
    f1 = (m * L * L * 11 / 40 + p * L) * qa + m * La * c1 + 2 * m * Lr * d1 + 2 * Lr * q * (m * L * 3 / 8 + p)
    f2 = m * L * L / 12 * qa + m * La * c2 + 2 * m * Lr * d2 + 2 * Lr * q * m * L * 3 / 20
    f1 += -q * q * (m11 * n1 + m12 * n2) - m * Lr * Lr / L * e1 + 3 * (stiffness * n1 + damping * v1)
    f2 += -q * q * (m12 * n1 + m22 * n2) - m * Lr * Lr / L * e2 + 7.2 * (stiffness * n2 + damping * v2)
    det = m11 * m22 - m12 * m12
    return [v1, v2, -(m22 * f1 - m12 * f2) / det, -(m11 * f2 - m12 * f1) / det]


def hold_amplitudes(w: Array, w_rate: Array, length: Array, move_ends_s: tuple[float, ...] = (3.1, 11.2, 16.3)) -> list[float]:
    """Amplitude of the tip's vibration acceleration (m/s²) 1.0 s after the end of every move."""
    amplitudes = []
    for end in move_ends_s:
        i = round((end + 1.0) / PERIOD_S)
        omega = 2 * pi * frequency_Hz(length[i])
        amplitudes.append(omega**2 * float(np.hypot(w[i], w_rate[i] / omega)))
    return amplitudes


def tip_acceleration(w: Array, w_rate: Array, theta_rate: Array, length: Array, length_rate: Array) -> Array:
    """What a transverse accelerometer at the tip reads: ẅ + L θ̈ + 2 L̇ θ̇ − w θ̇² (m/s²)."""
    theta_acc = np.gradient(theta_rate, PERIOD_S)
    return np.gradient(w_rate, PERIOD_S) + length * theta_acc + 2 * length_rate * theta_rate - w * theta_rate**2


def largest_line(acceleration: Array) -> float:
    """Largest line of the Hann spectrum of the whole record between 1 and 25 Hz."""
    spectrum = np.abs(np.fft.rfft(acceleration * np.hanning(len(acceleration))))
    f = np.fft.rfftfreq(len(acceleration), PERIOD_S)
    return float(spectrum[(f >= 1) & (f <= 25)].max())
