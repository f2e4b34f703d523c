"""The clamped link's frequency and damping from one hold, whatever the joint does meanwhile.

The joint yields: oil and bristles are a spring, and the servo acts too. Its motion is measured, so nothing has to be known
about it. With tip acceleration and joint angle a sum of e^{st} each (s = −σ + jω, phasors A and Θ), the deflection is W = A/s² − LΘ
and the link's own equation gives frequency and damping:

    s² (1 + αΘ/W) + 2ζω_c s + ω_c² = 0,        α = L (M + 11/40 mL) / (M + 33/140 mL)

Real and imaginary part are two equations for ω_c² and 2ζω_c.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, pi, sqrt

import numpy as np
from scipy.optimize import minimize

from config.schema.rig import LinkMode
from recording.evaluation.spectrum import hann_spectrum
from tuning.arrays import Floats
from tuning.link_and_payload.tip_record import TipRecord

PADDING = 8
SMALLEST_MPS2 = 0.05  # amplitude of a usable hold: below this, noise dominates
LOWEST_PERIODS = 1.5  # of the hold's length: slower lines are drift
LARGEST_RING_DAMPING = 0.05  # of a usable hold: what dies out faster is too short, and small lags between the sensors count too much
DECAY_GUESS_PER_S = 0.1
GIVE_SHARE = 0.1  # of the correction for the joint's motion that is not believed: friction's bristles are no linear spring
LINK_MASS, LINK_INERTIA = 33.0 / 140.0, 11.0 / 40.0  # shares of the link's own mass in the static shape


@dataclass(frozen=True, slots=True)
class FreeVibration:
    """One hold. Frequencies in Hz: `frequency_Hz` as it rings, with the joint that gives; `clamped_Hz` and `damping_ratio` of the link
    alone; `clamped_sigma_Hz`, `damping_sigma` their standard deviations, from the signals' noise and the joint's friction; amplitude
    (m/s²) at the hold's start."""

    move: int
    extension_m: float
    amplitude_mps2: float
    frequency_Hz: float
    ring_damping_ratio: float
    clamped_Hz: float
    clamped_sigma_Hz: float
    damping_ratio: float
    damping_sigma: float


def free_vibrations(record: TipRecord, link: LinkMode) -> list[FreeVibration]:
    """Every hold of a run that rings on: large and long enough to be measured."""
    holds = [free_vibration(record, move, rows, link) for move, rows in record.holds]
    return [hold for hold in holds if hold.amplitude_mps2 > SMALLEST_MPS2 and abs(hold.ring_damping_ratio) < LARGEST_RING_DAMPING]


def free_vibration(record: TipRecord, move: int, rows: slice, link: LinkMode) -> FreeVibration:
    """One hold. The link's constants only enter through α, which a wrong payload changes by less than 1 %."""
    acceleration, rotary = record.acceleration[rows], record.rotary[rows]
    length = float(np.mean(record.extension[rows]))
    t = record.period_s * np.arange(len(acceleration), dtype=np.float64)
    decay, omega = _fit(t, acceleration, 2.0 * pi * _largest_line_Hz(acceleration, record.period_s))
    s = complex(-decay, omega)
    tip, noise = _phasor(t, acceleration, decay, omega)
    tip *= 1.0 + s * record.tip_lag_s
    joint, joint_noise = _phasor(t, rotary, decay, omega)
    clamped_squared, drag = _link_alone(s, tip, joint, length, _arm(link, length))
    clamped = sqrt(clamped_squared) if clamped_squared > 0.0 else omega
    share = _sigma(t, decay, abs(tip), noise), joint_noise * sqrt(2.0 / len(t)) * omega**2 * length / abs(tip)
    given = abs(clamped_squared / abs(s) ** 2 - 1.0)  # the joint's part
    damping = 0.5 * drag / clamped
    # A damping ratio that the link does not have says how far both motions are from one decaying sine (friction, a feedback that lags):
    # the frequency is then off by as much. Of the damping itself, half of what the joint took out of the ringing is not believed.
    astray, taken = abs(damping - link.damping_ratio), abs(decay / omega - damping)
    noise = hypot(share[0] / omega, 0.5 * share[1], 0.5 * GIVE_SHARE * given)
    sigma, damping_sigma = hypot(noise, 0.5 * astray), hypot(noise, 0.5 * taken)  # relative, of the clamped frequency; absolute
    return FreeVibration(
        move, length, abs(tip), omega / (2.0 * pi), decay / omega, clamped / (2.0 * pi), sigma * clamped / (2.0 * pi),
        damping, damping_sigma,
    )  # fmt: skip


def _arm(link: LinkMode, length: float) -> float:
    own = link.mass_per_length_kg_per_m * length
    return length * (link.payload_kg + LINK_INERTIA * own) / (link.payload_kg + LINK_MASS * own)


def _link_alone(s: complex, tip: complex, joint: complex, length: float, arm: float) -> tuple[float, float]:
    """ω_c² and 2ζω_c."""
    deflection = tip / s**2 - length * joint
    z = s**2 * (1.0 + arm * joint / deflection)
    drag = -z.imag / s.imag
    return -(z.real + drag * s.real), drag


def _largest_line_Hz(values: Floats, period_s: float) -> float:
    padded = np.concatenate([values - np.mean(values), np.zeros((PADDING - 1) * len(values))])
    frequencies, lines = hann_spectrum(padded, period_s)
    return float(frequencies[np.argmax(np.where(frequencies > LOWEST_PERIODS / (len(values) * period_s), lines, 0.0))])


def _basis(t: Floats, decay: float, omega: float) -> Floats:
    """Decaying cosine and sine, and the slow drift beside them."""
    envelope = np.exp(-decay * t)
    return np.column_stack([envelope * np.cos(omega * t), envelope * np.sin(omega * t), np.ones_like(t), t])


def _fit(t: Floats, values: Floats, start: float) -> tuple[float, float]:
    """Decay rate (1/s) and ω (rad/s) of the decaying sine that leaves least of the values, amplitudes being linear in it."""

    def left(parameters: Floats) -> float:
        q, _ = np.linalg.qr(_basis(t, parameters[1], parameters[0]))
        rest = values - q @ (q.T @ values)
        return float(rest @ rest)

    best = minimize(left, [start, DECAY_GUESS_PER_S], method="Nelder-Mead", options={"xatol": 1e-6 * start, "fatol": 1e-12})
    return float(best.x[1]), float(best.x[0])


def _phasor(t: Floats, values: Floats, decay: float, omega: float) -> tuple[complex, float]:
    """Complex amplitude X of Re(X e^{st}), and the standard deviation of what is left."""
    basis = _basis(t, decay, omega)
    c = np.linalg.lstsq(basis, values, rcond=None)[0]
    return complex(c[0], -c[1]), float(np.std(values - basis @ c))


def _sigma(t: Floats, decay: float, amplitude: float, noise: float) -> float:
    """Standard deviation of ω (and of the decay rate) by the Cramér-Rao bound of a sine whose amplitude is its mean over the window
    (S. Kay, Fundamentals of Statistical Signal Processing: Estimation Theory, 1993, chapter 3)."""
    length_s = float(t[-1] - t[0])
    mean = amplitude * float(np.mean(np.exp(-decay * t)))
    return sqrt(24.0 / len(t)) * noise / (mean * length_s)
