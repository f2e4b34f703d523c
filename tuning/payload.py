"""The payload from the link's free vibration after an ordinary move.

In a hold the joint is stuck, but not rigid: oil and friction's bristles give like a spring k_j, which lowers the clamped frequency,

    f² = f_clamped(L, M)² / (1 + 3 EI / (L k_j)),

the link's own stiffness at its root being 3 EI/L. k_j is measured once, from a move with a known payload.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np
from scipy.optimize import brentq

from config.errors import LogError
from config.rig import LinkMode
from control.link_mode import LinkFrequency
from recording.spectrum import hann_spectrum
from recording.vibration import decaying_sine
from tuning.line_run import LineRun
from tuning.transfer import Floats

SKIPPED_S = 0.1  # after the move's end, while the joint comes to rest
LONGEST_S = 1.85
LARGEST_PAYLOAD_KG = 200.0
SMALLEST_MPS2 = 0.05  # below this the accelerometer's noise decides
ONE_SHAPE_ERROR = 0.0147  # by which the static shape is stiff without payload; it fades with the payload's share of the mass
PADDING = 8


@dataclass(frozen=True, slots=True)
class Hold:
    """Free vibration in one hold: extension in m, frequency in Hz, amplitude in m/s²."""

    extension_m: float
    frequency_Hz: float
    amplitude_mps2: float


def free_vibration(acceleration: Floats, period_s: float, extension_m: float, damping_ratio: float = 0.01) -> Hold:
    """Frequency and amplitude of the largest line, refined by fitting a decaying sine. No belief about the payload is needed."""
    padded = np.concatenate([acceleration - np.mean(acceleration), np.zeros((PADDING - 1) * len(acceleration))])
    frequencies, lines = hann_spectrum(padded, period_s)
    start = float(frequencies[np.argmax(np.where(frequencies > 1.0 / (len(acceleration) * period_s), lines, 0.0))])
    amplitude, frequency = decaying_sine(period_s * np.arange(len(acceleration), dtype=np.float64), acceleration, start, damping_ratio)
    return Hold(extension_m, frequency, amplitude)


def holds_of(run: LineRun, acceleration: Floats | None = None) -> list[Hold]:
    """Every hold of a run; `acceleration` replaces the true one, for a sensor's."""
    signal = run.tip_acceleration if acceleration is None else acceleration
    found = []
    for end in run.move_ends_s:
        rows = slice(round((end + SKIPPED_S) / run.period_s), round((end + SKIPPED_S + LONGEST_S) / run.period_s))
        found.append(free_vibration(signal[rows], run.period_s, float(np.mean(run.position[rows, 1]))))
    return found


def clamped_Hz(link: LinkMode, payload_kg: float, extension_m: float) -> float:
    """First clamped frequency; the static shape's error without payload is taken off by the link's share of the modal mass."""
    own = 33.0 / 140.0 * link.mass_per_length_kg_per_m * extension_m
    high = 1.0 + ONE_SHAPE_ERROR * (own / (own + payload_kg)) ** 2
    return LinkFrequency(link.model_copy(update={"payload_kg": payload_kg})).frequency_Hz(extension_m) / high


def joint_stiffness(link: LinkMode, payload_kg: float, holds: Sequence[Hold]) -> float:
    """k_j in N·m/rad from holds with a known payload."""
    values = []
    for hold in _good(holds):
        excess = (clamped_Hz(link, payload_kg, hold.extension_m) / hold.frequency_Hz) ** 2 - 1.0
        values.append(3.0 * link.bending_stiffness_N_m2 / hold.extension_m / excess)
    return float(np.median(values))


def payload(link: LinkMode, joint_stiffness_N_m_per_rad: float, holds: Sequence[Hold]) -> float:
    """The payload in kg; mean over the holds weighted by amplitude. Raises LogError when nothing vibrated."""
    good = _good(holds)
    found = [_payload_of(link, joint_stiffness_N_m_per_rad, hold) for hold in good]
    return float(np.average(found, weights=[hold.amplitude_mps2 for hold in good]))


def _payload_of(link: LinkMode, stiffness: float, hold: Hold) -> float:
    free = hold.frequency_Hz * sqrt(1.0 + 3.0 * link.bending_stiffness_N_m2 / (hold.extension_m * stiffness))

    def excess(mass_kg: float) -> float:
        return clamped_Hz(link, mass_kg, hold.extension_m) - free

    return float(brentq(excess, 0.0, LARGEST_PAYLOAD_KG)) if excess(0.0) > 0.0 else 0.0


def _good(holds: Sequence[Hold]) -> list[Hold]:
    good = [hold for hold in holds if hold.amplitude_mps2 > SMALLEST_MPS2]
    if not good:
        largest = max((hold.amplitude_mps2 for hold in holds), default=0.0)
        advice = "Use a move without command filter."
        raise LogError(
            "the link does not vibrate enough in the holds", value=f"{largest:.3f}", limit=SMALLEST_MPS2, unit="m/s²", next_step=advice
        )
    return good
