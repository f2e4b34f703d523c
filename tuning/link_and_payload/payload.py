"""The payload from one ordinary move, in two independent ways.

Balance of forces at the tip, at every moment of the move, shaped or not; needs a deflection sensor. One static shape
in (P22) to (P25) of docs/method/plant.md, a_j the accelerometer:

    M a_j = −(3EI/L³) w − mL [33/140 a_j + (11/40 − 33/140) L θ̈ + (3/4 − 66/140) L̇ θ̇] − damping

Free vibration in the holds, corrected for the joint's measured motion (`free_vibration`); needs the accelerometer alone, but
something must be left that vibrates. Both scale with EI: an error of the rig file's bending stiffness goes into the payload one to one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, sqrt
from typing import Literal

import numpy as np
from scipy.optimize import brentq
from scipy.signal import butter, sosfiltfilt

from config.errors import LogError
from config.schema.rig import LinkMode
from servo_control.link.link_mode import LinkFrequency
from tuning.arrays import Floats
from tuning.link_and_payload.free_vibration import LINK_INERTIA, LINK_MASS, SMALLEST_MPS2, FreeVibration, free_vibrations
from tuning.link_and_payload.tip_record import TipRecord

LARGEST_PAYLOAD_KG = 500.0
ONE_SHAPE_ERROR = 0.0147  # of the static shape without payload (docs/method/plant.md, P29); it fades with the payload's share of the mass
BAND_HZ = (0.5, 10.0)  # of the balance: above the bias' drift, below the second mode and the accelerometer's lag
SMOOTH_HZ = 30.0  # low-pass on the joints before they are differentiated
BLOCK_S = 1.0
# What one shape and unequal lags of the sensors leave: 0.4 % and 0.02 lb on the simulated rig, 0 to 75 lb, shaped and unshaped.
MODEL_SHARE, MODEL_KG = 0.004, 0.01

Method = Literal["balance", "free vibration"]


@dataclass(frozen=True, slots=True)
class PayloadEstimate:
    """Payload in kg and its uncertainty (two standard deviations; without that of the bending stiffness), and how it was found."""

    payload_kg: float
    uncertainty_kg: float
    method: Method
    samples: int


def identify_payload(records: Sequence[TipRecord], link: LinkMode) -> list[PayloadEstimate]:
    """One estimate by each method that the runs allow, the more certain first. Raises LogError when nothing moved enough."""
    balances = [estimate for record in records if (estimate := _balance(record, link)) is not None]
    vibration = _vibration(records, link)
    found = [*([_together(balances)] if balances else []), *([vibration] if vibration is not None else [])]
    if not found:
        raise LogError(
            "the tip moved too little to weigh its payload", limit=SMALLEST_MPS2, unit="m/s²", next_step="Use a faster move, or no filter."
        )
    return sorted(found, key=lambda estimate: estimate.uncertainty_kg)


def disagreement(estimates: Sequence[PayloadEstimate]) -> str:
    """A sentence when two estimates are farther apart than their uncertainties; empty otherwise."""
    best = estimates[0]
    for other in estimates[1:]:
        apart, allowed = abs(other.payload_kg - best.payload_kg), hypot(other.uncertainty_kg, best.uncertainty_kg)
        if apart > allowed:
            return (
                f"{best.method} says {best.payload_kg:.3f} kg, {other.method} {other.payload_kg:.3f} kg: {apart:.3f} kg apart, "
                f"{allowed:.3f} kg expected. Calibration of a tip sensor or of the link's stiffness?"
            )
    return ""


def clamped_Hz(link: LinkMode, payload_kg: float, extension_m: float) -> float:
    """First clamped frequency; the static shape's error without payload is taken off by the link's share of the modal mass."""
    own = LINK_MASS * link.mass_per_length_kg_per_m * extension_m
    high = 1.0 + ONE_SHAPE_ERROR * (own / (own + payload_kg)) ** 2
    return LinkFrequency(link.model_copy(update={"payload_kg": payload_kg, "frequency_map": ()})).frequency_Hz(extension_m) / high


def payload_of_hold(link: LinkMode, hold: FreeVibration) -> tuple[float, float]:
    """Payload in kg from one hold's clamped frequency, and its standard deviation."""
    own = LINK_MASS * link.mass_per_length_kg_per_m * hold.extension_m

    def excess(mass_kg: float) -> float:
        return clamped_Hz(link, mass_kg, hold.extension_m) - hold.clamped_Hz

    mass = float(brentq(excess, 0.0, LARGEST_PAYLOAD_KG)) if excess(0.0) > 0.0 > excess(LARGEST_PAYLOAD_KG) else 0.0
    return mass, 2.0 * hold.clamped_sigma_Hz / hold.clamped_Hz * (mass + own)


def _together(estimates: Sequence[PayloadEstimate]) -> PayloadEstimate:
    """Mean of several runs, weighted by certainty, with the smallest uncertainty: repeating does not reduce the model's error."""
    weights = [1.0 / estimate.uncertainty_kg**2 for estimate in estimates]
    mean = float(np.average([estimate.payload_kg for estimate in estimates], weights=weights))
    least = min(estimate.uncertainty_kg for estimate in estimates)
    return PayloadEstimate(mean, least, estimates[0].method, sum(estimate.samples for estimate in estimates))


def _vibration(records: Sequence[TipRecord], link: LinkMode) -> PayloadEstimate | None:
    """Mean over the holds weighted by their certainty; their spread counts when it is larger than their certainties explain."""
    holds = [hold for record in records for hold in free_vibrations(record, link)]
    if not holds:
        return None
    found = np.array([payload_of_hold(link, hold) for hold in holds])
    floors = np.hypot(found[:, 1], MODEL_SHARE * found[:, 0] + MODEL_KG)
    weights = 1.0 / floors**2
    mean = float(np.average(found[:, 0], weights=weights))
    spread = float(np.average((found[:, 0] - mean) ** 2, weights=weights)) / max(1, len(holds) - 1)
    known = sqrt(max(spread, 1.0 / float(np.sum(weights))))
    samples = sum(rows.stop - rows.start for record in records for _, rows in record.holds)
    return PayloadEstimate(mean, 2.0 * hypot(known, MODEL_SHARE * mean + MODEL_KG), "free vibration", samples)


def _balance(record: TipRecord, link: LinkMode) -> PayloadEstimate | None:
    """Least squares over the whole run; the uncertainty from leaving out one second after the other."""
    if record.deflection is None or len(record.acceleration) * record.period_s < 4.0 * BLOCK_S:
        return None
    force, acceleration = (_band(values, record.period_s) for values in (_tip_force(record, link), record.acceleration))
    if sqrt(float(np.mean(acceleration**2))) < SMALLEST_MPS2:
        return None
    slope = np.gradient(acceleration, record.period_s)  # damping, and lags between the two sensors
    mass, lag = np.linalg.lstsq(np.column_stack([acceleration, slope]), force, rcond=None)[0]
    spread = _jackknife(acceleration, force - lag * slope, round(BLOCK_S / record.period_s))
    return PayloadEstimate(max(float(mass), 0.0), hypot(2.0 * spread, MODEL_SHARE * float(mass) + MODEL_KG), "balance", len(force))


def _tip_force(record: TipRecord, link: LinkMode) -> Floats:
    """What accelerates the payload, in N: the beam's stiffness less the beam's own inertia."""
    assert record.deflection is not None
    theta, length = (_smooth(values, record.period_s) for values in (record.rotary, record.extension))
    rate, length_rate = np.gradient(theta, record.period_s), np.gradient(length, record.period_s)
    own = link.mass_per_length_kg_per_m * length
    carried = (LINK_INERTIA - LINK_MASS) * length * np.gradient(rate, record.period_s) + (0.75 - 2.0 * LINK_MASS) * length_rate * rate
    stiffness = 3.0 * link.bending_stiffness_N_m2 / length**3
    return np.asarray(-stiffness * record.deflection - own * (LINK_MASS * record.acceleration + carried), dtype=np.float64)


def _smooth(values: Floats, period_s: float) -> Floats:
    return np.asarray(sosfiltfilt(butter(2, SMOOTH_HZ, fs=1.0 / period_s, output="sos"), values), dtype=np.float64)


def _band(values: Floats, period_s: float) -> Floats:
    """Band-passed without phase; the ends, where the filter starts, are cut off."""
    cut = round(0.5 / BAND_HZ[0] / period_s / 2.0)
    filtered = sosfiltfilt(butter(2, BAND_HZ, "bandpass", fs=1.0 / period_s, output="sos"), values)
    return np.asarray(filtered[cut:-cut], dtype=np.float64)


def _jackknife(x: Floats, y: Floats, block: int) -> float:
    """Standard deviation of Σxy/Σx² over blocks of samples left out one at a time."""
    count = len(x) // block
    products = np.array([[x[rows] @ y[rows], x[rows] @ x[rows]] for rows in (slice(n * block, (n + 1) * block) for n in range(count))])
    without = (products[:, 0].sum() - products[:, 0]) / (products[:, 1].sum() - products[:, 1])
    return sqrt((count - 1) / count * float(np.sum((without - np.mean(without)) ** 2)))
