"""The rotary joint as the paper and its data describe it: Eq 4, corrected Eq 1, and the family a compensator must be robust to.

Corrected Eq 1 (Merritt): θ̇/u = K ω_h² / (s² + (a_l + b) s + ω_h² + a_l b), leak rate a_l, viscous rate b = B/J, hydraulic
frequency ω_h² = 4 β_e D²/(V_t J). Eq 4 fixes a_l + b = 140 and ω_h² + a_l b = 6150, not the split; a_l = 10 is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from scipy.linalg import expm

from control.lag_lead import section_coefficients
from tuning.closed_loop import Servo
from tuning.transfer import Complexes, Floats, TransferFunction

SUM_PER_S, PRODUCT_PER_S2, NUMERATOR = 140.0, 6150.0, 240810.0
LEAK_PER_S = 10.0
GAINS = (0.8, 1.0, 1.2)  # the paper's ±20 %
INERTIAS = (0.8, 1.0, 1.5, 2.3)  # extension and payload, as the hub feels them
HALF_HOLD_AND_SAMPLE_S = 0.0015


@dataclass(frozen=True, slots=True)
class Member:
    """One plant of the family: factors on gain and inertia."""

    gain: float = 1.0
    inertia: float = 1.0


def eq1(member: Member, leak_per_s: float = LEAK_PER_S) -> TransferFunction:
    """Corrected Eq 1 with the numbers of Eq 4 for this member, position in degrees per volt."""
    viscous = SUM_PER_S - leak_per_s
    stiffness = PRODUCT_PER_S2 - leak_per_s * viscous
    b, square = viscous / member.inertia, stiffness / member.inertia
    return TransferFunction((member.gain * NUMERATOR / member.inertia,), (1.0, leak_per_s + b, square + leak_per_s * b, 0.0))


def valve(frequency_Hz: float, damping: float) -> TransferFunction:
    """Second-order spool."""
    w = 2.0 * pi * frequency_Hz
    return TransferFunction((w * w,), (1.0, 2.0 * damping * w, w * w))


def members(gains: Sequence[float] = GAINS, inertias: Sequence[float] = (1.0,)) -> list[Member]:
    return [Member(gain, inertia) for gain in gains for inertia in inertias]


def compensator_response(servo: Servo, omega: Floats) -> Complexes:
    """C(jω), continuous; V per unit of error in the unit of the gain."""
    s = 1j * omega
    result = np.full(omega.shape, servo.gain, dtype=np.complex128)
    for zero, pole in servo.sections:
        result = result * (1.0 + s / zero) / (1.0 + s / pole)
    return result


def sampled_compensator(servo: Servo, omega: Floats, period_s: float) -> Complexes:
    """C(e^{jωT}) of the difference equations that run in the loop."""
    back = np.exp(-1j * omega * period_s)
    result = np.full(omega.shape, servo.gain, dtype=np.complex128)
    for zero, pole in servo.sections:
        b0, b1, a1 = section_coefficients(zero, pole, period_s)
        result = result * (b0 + b1 * back) / (1.0 + a1 * back)
    return result


def sampled_plant(plant: TransferFunction, omega: Floats, period_s: float, delay_periods: int = 1) -> Complexes:
    """Response of the plant behind a hold, at the samples, with whole periods of delay."""
    a, b, c = plant.state_space()
    n = b.size
    block = np.zeros((n + 1, n + 1))
    block[:n, :n], block[:n, n] = a, b
    whole = expm(block * period_s)
    z = np.exp(1j * omega * period_s)
    right = np.broadcast_to(whole[:n, n][:, None], (omega.size, n, 1))
    states = np.linalg.solve(z[:, None, None] * np.eye(n) - whole[:n, :n], right)[:, :, 0]
    return np.asarray((states @ c) * z**-delay_periods)
