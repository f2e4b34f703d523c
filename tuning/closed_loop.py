"""Damping of the arm's modes with the joint servo closed: lag-lead and end-point feedback, continuous or as sampled by the loop."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import exp, inf, pi

import numpy as np
from scipy.linalg import expm

from control.lag_lead import section_coefficients
from tuning.linear_arm import LinearArm
from tuning.transfer import Complexes, Floats


@dataclass(frozen=True, slots=True)
class Servo:
    """Gain in V/rad, sections as (zero, pole) in rad/s, gain of the reflected tip and corner of its low-pass (0: no low-pass).

    `tip_lead`: shares of the low-passed deflection and of what the low-pass takes away, see `control.end_point.lead_shares`.
    `push`: V per rad of the tip's correction that do not pass the sections, against the friction of a resting joint; sampled loops only.
    """

    gain: float
    sections: tuple[tuple[float, float], ...] = ()
    tip_gain: float = 0.0
    roll_off_Hz: float = 15.0
    push: float = 0.0
    tip_lead: tuple[float, float] = (1.0, 0.0)


@dataclass(frozen=True, slots=True)
class Mode:
    """One pole pair, or one real pole (frequency of its magnitude, damping ±1)."""

    frequency_Hz: float
    damping_ratio: float


def modes(matrix: Floats, period_s: float | None = None) -> list[Mode]:
    """Modes of a system matrix, by damping. `period_s`: the matrix advances a sampled loop by one period."""
    poles: Complexes = np.asarray(np.linalg.eigvals(matrix), dtype=np.complex128)
    if period_s is not None:
        poles = np.asarray(np.log(poles[np.abs(poles) > 1e-9]) / period_s, dtype=np.complex128)
    found = [Mode(float(abs(p)) / (2.0 * pi), float(-p.real / abs(p))) for p in poles if abs(p) > 1e-6 and p.imag >= 0.0]
    return sorted(found, key=lambda mode: mode.damping_ratio)


def least_damping(matrix: Floats, period_s: float | None = None, below_Hz: float = inf) -> float:
    """Smallest damping ratio of the modes below a frequency; negative for an unstable loop."""
    return min(mode.damping_ratio for mode in modes(matrix, period_s) if mode.frequency_Hz < below_Hz)


def continuous_loop(arm: LinearArm, servo: Servo) -> Floats:
    """System matrix of arm, tip low-pass and lag-lead without sampling or delay."""
    n, count = len(arm.b), len(servo.sections)
    total = np.zeros((n + 1 + count, n + 1 + count))
    error = np.zeros(total.shape[0])
    corner = 2.0 * pi * servo.roll_off_Hz
    total[:n, :n] = arm.a
    total[n, :n], total[n, n] = corner * arm.deflection, -corner
    error[:n] = -arm.position
    if servo.roll_off_Hz > 0.0:
        kept, lead = servo.tip_lead
        error[n] = (kept - lead) * servo.tip_gain / arm.extension_m
        error[:n] += lead * servo.tip_gain / arm.extension_m * arm.deflection
    else:
        error[:n] += servo.tip_gain / arm.extension_m * arm.deflection
    signal = servo.gain * error
    for i, (zero, pole) in enumerate(servo.sections, start=n + 1):
        # (1 + s/z)/(1 + s/p) = p/z + (1 − p/z) · p/(s + p)
        total[i] = pole * signal
        total[i, i] -= pole
        signal = pole / zero * signal
        signal[i] += 1.0 - pole / zero
    total[:n] += np.outer(arm.b, signal)
    return total


def sampled_loop(arm: LinearArm, servo: Servo, period_s: float, delay_periods: int = 0) -> Floats:
    """One period of the loop as it runs: sampled positions, the controller's difference equations, the command held.

    `delay_periods`: whole periods between the sample and the moment its command acts (0 in the simulated rig; 1 for slow outputs).
    """
    n, count = len(arm.b), len(servo.sections)
    size = n + 1 + count + delay_periods
    plant, drive = _held(arm, period_s)
    total, now = np.zeros((size, size)), np.eye(size)
    share = 1.0 - exp(-2.0 * pi * servo.roll_off_Hz * period_s) if servo.roll_off_Hz > 0.0 else 1.0
    filtered = (1.0 - share) * now[n]
    filtered[:n] += share * arm.deflection
    total[n] = filtered
    kept, lead = servo.tip_lead
    tip = (kept - lead) * filtered
    tip[:n] += lead * arm.deflection
    tip *= servo.tip_gain / arm.extension_m
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


@lru_cache(maxsize=512)
def _held(arm: LinearArm, period_s: float) -> tuple[Floats, Floats]:
    """Transition over one period with the command held."""
    n = len(arm.b)
    block = np.zeros((n + 1, n + 1))
    block[:n, :n], block[:n, n] = arm.a, arm.b
    whole = expm(block * period_s)
    return np.asarray(whole[:n, :n]), np.asarray(whole[:n, n])
