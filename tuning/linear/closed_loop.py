"""Damping of the arm's modes with the joint servo closed: lag-lead and end-point feedback, continuous or as sampled by the loop."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import exp, inf, pi
from typing import NamedTuple

import control
import numpy as np

from servo_control.servo.lag_lead import section_coefficients
from tuning.arrays import Complexes, Floats
from tuning.linear.linear_arm import LinearArm


@dataclass(frozen=True, slots=True)
class Servo:
    """Gain in V/rad, sections as (zero, pole) in rad/s, gain of the reflected tip and corner of its low-pass (0: no low-pass).

    `tip_lead`: shares of the low-passed deflection and of what the low-pass takes away, see `servo_control.link.end_point.lead_shares`.
    `push`: V per rad of the tip's correction that do not pass the sections, against the friction of a resting joint; sampled loops only.
    """

    gain: float
    sections: tuple[tuple[float, float], ...] = ()
    tip_gain: float = 0.0
    roll_off_Hz: float = 15.0
    push: float = 0.0
    tip_lead: tuple[float, float] = (1.0, 0.0)


class Modes(NamedTuple):
    """Pole pairs, and real poles (frequency of their magnitude, damping ±1); one entry each."""

    frequency_Hz: Floats
    damping_ratio: Floats


def modes(matrix: Floats, period_s: float | None = None) -> Modes:
    """Modes of a system matrix. `period_s`: the matrix advances a sampled loop by one period."""
    poles: Complexes = np.asarray(np.linalg.eigvals(matrix), dtype=np.complex128)
    if period_s is not None:
        poles = np.asarray(np.log(poles[np.abs(poles) > 1e-9]) / period_s, dtype=np.complex128)
    poles = poles[(np.abs(poles) > 1e-6) & (poles.imag >= 0.0)]
    size = np.abs(poles)
    return Modes(size / (2.0 * pi), -poles.real / size)


def least_damping(matrix: Floats, period_s: float | None = None, below_Hz: float = inf) -> float:
    """Smallest damping ratio of the modes below a frequency; negative for an unstable loop."""
    found = modes(matrix, period_s)
    return float(found.damping_ratio[found.frequency_Hz < below_Hz].min())


def sampled_loop(arm: LinearArm, servo: Servo, period_s: float, delay_periods: int = 0) -> Floats:
    """One period of the loop as it runs: sampled positions, the controller's difference equations, the command held.

    `delay_periods`: whole periods between the sample and the moment its command acts (0 in the simulated rig; 1 for slow outputs).
    """
    n, count = len(arm.b), len(servo.sections)
    size = n + 1 + count + delay_periods
    plant, drive = _held(arm, period_s)
    total, now = np.zeros((size, size)), np.eye(size)
    total[n], tip = _tip_feedback(arm, servo, period_s, now[n])
    signal = servo.gain * tip
    signal[:n] -= servo.gain * arm.position
    for i, (zero, pole) in enumerate(servo.sections, start=n + 1):
        b0, b1, a1 = section_coefficients(zero, pole, period_s)
        output = b0 * signal + now[i]
        total[i] = b1 * signal - a1 * output
        signal = output
    signal = signal + servo.push * tip
    for i in range(size - delay_periods, size):
        total[i] = signal
        signal = now[i]
    total[:n, :n] += plant
    total[:n] += np.outer(drive, signal)
    return total


def _tip_feedback(arm: LinearArm, servo: Servo, period_s: float, filter_state: Floats) -> tuple[Floats, Floats]:
    """Rows over the loop's states: the low-pass filter's next state, and the tip's share of the reference."""
    n = len(arm.b)
    share = 1.0 - exp(-2.0 * pi * servo.roll_off_Hz * period_s) if servo.roll_off_Hz > 0.0 else 1.0
    filtered = (1.0 - share) * filter_state
    filtered[:n] += share * arm.deflection
    kept, lead = servo.tip_lead
    tip = (kept - lead) * filtered
    tip[:n] += lead * arm.deflection
    return filtered, tip * (servo.tip_gain / arm.extension_m)


@lru_cache(maxsize=512)
def _held(arm: LinearArm, period_s: float) -> tuple[Floats, Floats]:
    """Transition over one period with the command held."""
    held = control.c2d(arm.system(), period_s, "zoh")
    return held.A, held.B[:, 0]
