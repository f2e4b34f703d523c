"""The rotary joint as the paper and its data describe it: Eq 4, corrected Eq 1, and the family a compensator must be robust to.

Corrected Eq 1 (Merritt): θ̇/u = K ω_h² / (s² + (a_l + b) s + ω_h² + a_l b), leak rate a_l, viscous rate b = B/J, hydraulic
frequency ω_h² = 4 β_e D²/(V_t J). Eq 4 fixes a_l + b = 140 and ω_h² + a_l b = 6150, not the split; a_l = 10 is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import control
import numpy as np

from servo_control.servo.lag_lead import section_coefficients
from tuning.arrays import Complexes, Floats
from tuning.eq4 import NUMERATOR, PRODUCT_PER_S2, SUM_PER_S
from tuning.linear.closed_loop import Servo

LEAK_PER_S = 10.0
GAINS = (0.8, 1.0, 1.2)  # the paper's ±20 %
INERTIAS = (0.8, 1.0, 1.5, 2.3)  # extension and payload, as the hub feels them
HALF_HOLD_AND_SAMPLE_S = 0.0015


@dataclass(frozen=True, slots=True)
class Member:
    """One plant of the family: factors on gain and inertia."""

    gain: float = 1.0
    inertia: float = 1.0


def eq1(member: Member, leak_per_s: float = LEAK_PER_S) -> control.TransferFunction:
    """Corrected Eq 1 with the numbers of Eq 4 for this member, position in degrees per volt."""
    viscous = SUM_PER_S - leak_per_s
    stiffness = PRODUCT_PER_S2 - leak_per_s * viscous
    b, square = viscous / member.inertia, stiffness / member.inertia
    return control.tf([member.gain * NUMERATOR / member.inertia], [1.0, leak_per_s + b, square + leak_per_s * b, 0.0])


def valve(frequency_Hz: float, damping: float) -> control.TransferFunction:
    """Second-order spool."""
    w = 2.0 * pi * frequency_Hz
    return control.tf([w * w], [1.0, 2.0 * damping * w, w * w])


def members(gains: Sequence[float] = GAINS, inertias: Sequence[float] = (1.0,)) -> list[Member]:
    return [Member(gain, inertia) for gain in gains for inertia in inertias]


def compensator_response(servo: Servo, omega: Floats) -> Complexes:
    """C(jω), continuous; V per unit of error in the unit of the gain. The search calls it at every step: thirty times as fast as
    `lag_lead(...)(1j * omega)`."""
    s = 1j * omega
    result = np.full(omega.shape, servo.gain, dtype=np.complex128)
    for zero, pole in servo.sections:
        result = result * (1.0 + s / zero) / (1.0 + s / pole)
    return result


def sampled_compensator(servo: Servo, period_s: float) -> control.TransferFunction:
    """C(z) of the difference equations that run in the loop."""
    result = control.tf([servo.gain], [1.0], period_s)
    for zero, pole in servo.sections:
        b0, b1, a1 = section_coefficients(zero, pole, period_s)
        result = result * control.tf([b0, b1], [1.0, a1], period_s)
    return result


def sampled_plant(plant: control.TransferFunction, period_s: float, delay_periods: int = 1) -> control.StateSpace:
    """The plant behind a hold, at the samples, with whole periods of delay. As a state space: the polynomials of a plant sampled much
    faster than it moves have lost their last digits."""
    delay = control.ss(control.tf([1.0], [1.0] + delay_periods * [0.0], period_s))
    return control.series(control.c2d(control.ss(plant), period_s, "zoh"), delay)
