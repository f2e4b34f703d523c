"""The link's frequency and damping from one run at constant extension, whatever joint, friction and end-point feedback do meanwhile.

With the tip's deflection w measured as well as its acceleration a, the link's own equation (one static shape, docs/method/tuning.md) is
linear in its unknowns at every moment:

    a + (α − L) θ̈ = −ω_c² w − 2ζω_c ẇ,        α = L (M + 11/40 mL) / (M + 33/140 mL)

The joint's motion enters by α − L alone, a hundredth of L. A lag δ between the two tip sensors looks like a damping ratio of −δω_c/2,
so one run does not tell the two apart; runs at several extensions do, as long as the link's own damping ratio does not grow with its
frequency itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, inf, pi, sqrt

import numpy as np
from scipy.signal import butter, sosfiltfilt

from config.schema.rig import LinkMode
from tuning.arrays import Floats
from tuning.link_and_payload.free_vibration import SMALLEST_MPS2
from tuning.link_and_payload.payload import clamped_Hz
from tuning.link_and_payload.tip_record import TipRecord

SAME_EXTENSION_M = 0.003
SHORTEST_S, SHORTEST_PERIODS = 1.0, 6.0
BAND = (0.5, 1.7)  # of the link's frequency
ROUNDS = 3  # in which the band follows the frequency found
BLOCKS = 10  # left out one after the other
MODEL_SHARE = 0.001  # of a frequency: one shape, rounding, differences
LEAST_DAMPING_SIGMA = 1e-4
LEAST_RATIO = 1.5  # of frequencies, for lag and damping to be told apart


@dataclass(frozen=True, slots=True)
class TipBalance:
    """One run. `clamped_Hz` of the link alone; `apparent_damping`: damping ratio less half the sensors' lag times ω. Standard deviations
    from the spread between parts of the run and from the deflection sensor's noise."""

    extension_m: float
    clamped_Hz: float
    clamped_sigma_Hz: float
    apparent_damping: float
    damping_sigma: float


@dataclass(frozen=True, slots=True)
class LinkDamping:
    """Damping ratio with two standard deviations; lag of the accelerometer behind the deflection sensor, s; `by_run`: damping ratio of
    every run with this lag taken out."""

    damping_ratio: float
    uncertainty: float
    lag_s: float
    by_run: tuple[float, ...]


def tip_balance(record: TipRecord, link: LinkMode) -> TipBalance | None:
    """None where the deflection is not measured, the arm does not stay at one extension long enough, or the tip hardly moves."""
    if record.deflection is None:
        return None
    rows = _at_last_extension(record.extension)
    if (rows.stop - rows.start) * record.period_s < SHORTEST_S:
        return None
    extension_m = float(np.mean(record.extension[rows]))
    frequency = clamped_Hz(link, link.payload_kg, extension_m)
    own = link.mass_per_length_kg_per_m * extension_m
    beyond = extension_m * (11.0 / 40.0 - 33.0 / 140.0) * own / (link.payload_kg + 33.0 / 140.0 * own)  # α − L
    signals = [values[rows] for values in (record.acceleration, record.deflection, record.rotary)]
    found = None
    for _ in range(ROUNDS):
        found = _fit(signals, record.period_s, frequency, beyond)
        if found is None:
            return None
        frequency = found[0]
    assert found is not None
    frequency, damping, sigma, damping_sigma = found
    return TipBalance(extension_m, frequency, hypot(sigma, MODEL_SHARE * frequency), damping, hypot(damping_sigma, LEAST_DAMPING_SIGMA))


def link_damping(balances: Sequence[TipBalance]) -> LinkDamping | None:
    """Damping and lag that fit all runs; None where their frequencies are too close to separate the two."""
    omega = np.array([2.0 * pi * each.clamped_Hz for each in balances])
    if len(omega) < 3 or omega.max() < LEAST_RATIO * omega.min():
        return None
    apparent, sigma = (np.array([getattr(each, name) for each in balances]) for name in ("apparent_damping", "damping_sigma"))
    columns = np.column_stack([np.ones(len(omega)), -0.5 * omega])
    weighted = columns / sigma[:, None]
    damping, lag = np.linalg.lstsq(weighted, apparent / sigma, rcond=None)[0]
    left = (apparent - columns @ [damping, lag]) / sigma
    scatter = max(1.0, float(left @ left) / (len(omega) - 2))
    deviation = sqrt(float(np.linalg.inv(weighted.T @ weighted)[0, 0]) * scatter)
    return LinkDamping(float(damping), 2.0 * deviation, float(lag), tuple((apparent + 0.5 * lag * omega).tolist()))


def _at_last_extension(extension: Floats) -> slice:
    """Rows from when the arm has come to the extension at which the run ends."""
    away = np.flatnonzero(np.abs(extension - np.median(extension[-len(extension) // 4 :])) > SAME_EXTENSION_M)
    return slice(int(away[-1]) + 1 if len(away) else 0, len(extension))


def _fit(signals: Sequence[Floats], period_s: float, frequency_Hz: float, beyond: float) -> tuple[float, float, float, float] | None:
    """Frequency (Hz), apparent damping, and their standard deviations."""
    edge = round(1.0 / frequency_Hz / period_s)
    if len(signals[0]) * period_s * frequency_Hz < SHORTEST_PERIODS or BAND[1] * frequency_Hz * period_s > 0.4:
        return None
    band = butter(2, [share * frequency_Hz for share in BAND], "bandpass", fs=1.0 / period_s, output="sos")
    tip, deflection, joint = (sosfiltfilt(band, values - np.mean(values)) for values in signals)
    force = tip + beyond * np.gradient(np.gradient(joint, period_s), period_s)
    rows = slice(edge, len(tip) - edge)
    x, y = np.column_stack([deflection, np.gradient(deflection, period_s)])[rows], force[rows]
    if sqrt(2.0 * float(np.mean(y**2))) < SMALLEST_MPS2:
        return None
    parts = [(block.T @ block, block.T @ push) for block, push in zip(np.array_split(x, BLOCKS), np.array_split(y, BLOCKS), strict=True)]
    square, product = sum(part[0] for part in parts), sum(part[1] for part in parts)
    frequency, damping = _constants(np.linalg.solve(square, product))
    left_out = np.array([_constants(np.linalg.solve(square - a, product - b)) for a, b in parts])
    spread = np.sqrt((BLOCKS - 1) / BLOCKS * np.sum((left_out - left_out.mean(axis=0)) ** 2, axis=0))
    noise = _noise_share(signals[1], x[:, 0], frequency_Hz, period_s)
    if not np.isfinite([frequency, damping, *spread]).all():
        return None
    return frequency, damping, hypot(float(spread[0]), 0.5 * noise * frequency), hypot(float(spread[1]), noise * abs(damping))


def _constants(solution: Floats) -> tuple[float, float]:
    """Frequency (Hz) and damping ratio of −ω², −2ζω."""
    omega = sqrt(-float(solution[0])) if solution[0] < 0.0 else inf
    return omega / (2.0 * pi), -float(solution[1]) / (2.0 * omega)


def _noise_share(raw: Floats, filtered: Floats, frequency_Hz: float, period_s: float) -> float:
    """Share of the deflection's power in the band that is noise: it makes the link look that much softer."""
    white = float(np.mean(np.diff(raw, 2) ** 2)) / 6.0
    return min(1.0, white * (BAND[1] - BAND[0]) * frequency_Hz * 2.0 * period_s / float(np.mean(filtered**2)))
