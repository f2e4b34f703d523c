"""The link's frequency and damping over the extension, from the holds of many moves and, with a deflection sensor, from whole runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot, nan, pi

import numpy as np

from config.errors import LogError
from config.schema.rig import LinkMode
from tuning.link_and_payload.free_vibration import SMALLEST_MPS2, FreeVibration
from tuning.link_and_payload.payload import clamped_Hz
from tuning.link_and_payload.tip_balance import LinkDamping, TipBalance, link_damping

SAME_PLACE_M = 0.01
MODEL_SHARE = 0.002  # of a frequency: what one static shape leaves
NOISE_SHARE = 2e-4  # of a ringing frequency: the fit to a hold of some seconds
LARGEST_DAMPING_SIGMA = 0.01  # holds whose damping is less certain do not count in its mean


@dataclass(frozen=True, slots=True)
class MapPoint:
    """Frequencies in Hz at one extension: as it rings (NaN: in no hold; end-point feedback), of the link alone, and what the rig file's
    constants say of the link alone. Standard deviations: the spread of the holds or what noise explains, whichever is larger."""

    extension_m: float
    ring_Hz: float
    clamped_Hz: float
    ring_sigma_Hz: float
    clamped_sigma_Hz: float
    believed_Hz: float
    damping_ratio: float
    holds: int


@dataclass(frozen=True, slots=True)
class LinkMap:
    """Points by rising extension; damping of the link with two standard deviations; stiffness EI that fits the clamped frequencies
    with the payload of the rig file, over its own EI; lag of the accelerometer behind the deflection sensor (NaN: not found)."""

    points: tuple[MapPoint, ...]
    damping_ratio: float
    damping_uncertainty: float
    stiffness_ratio: float
    sensor_lag_s: float


def link_map(link: LinkMode, holds: Sequence[FreeVibration], balances: Sequence[TipBalance] = ()) -> LinkMap:
    """`balances`: of whole runs, where the deflection is measured; they count before the holds. Raises LogError when there is neither."""
    if not (holds or balances):
        advice = "Use moves without command filter and, where the deflection is not measured, end_point.gain: 0 while the map is made."
        raise LogError("the link rings in no hold", limit=f"{SMALLEST_MPS2} and less than 5 % damping", unit="m/s²", next_step=advice)
    together = link_damping(balances)
    own = dict(zip(balances, together.by_run, strict=True)) if together is not None else {}
    points = tuple(_point(link, *place, together, own) for place in _places(holds, balances))
    ratios = [(point.clamped_Hz / point.believed_Hz) ** 2 for point in points]
    weights = [(point.believed_Hz / (point.clamped_sigma_Hz + MODEL_SHARE * point.believed_Hz)) ** 2 for point in points]
    ratio = float(np.average(ratios, weights=weights))
    if together is not None:
        return LinkMap(points, together.damping_ratio, together.uncertainty, ratio, together.lag_s)
    return LinkMap(points, *_damping(holds), ratio, nan)


def _places(holds: Sequence[FreeVibration], balances: Sequence[TipBalance]) -> list[tuple[list[FreeVibration], list[TipBalance]]]:
    """Those at the same extension, by rising extension."""
    places: list[tuple[float, list[FreeVibration], list[TipBalance]]] = []
    everything: list[FreeVibration | TipBalance] = [*holds, *balances]
    for each in sorted(everything, key=lambda one: one.extension_m):
        if not places or each.extension_m - places[-1][0] >= SAME_PLACE_M:
            places.append((each.extension_m, [], []))
        if isinstance(each, TipBalance):
            places[-1][2].append(each)
        else:
            places[-1][1].append(each)
    return [(ringing, whole) for _, ringing, whole in places]


def _point(
    link: LinkMode,
    holds: Sequence[FreeVibration],
    balances: Sequence[TipBalance],
    together: LinkDamping | None,
    own: Mapping[TipBalance, float],
) -> MapPoint:
    """From the runs where there are any; the lag between the sensors is no more than known."""
    ringing = _of_holds(link, holds) if holds else None
    if not balances:
        assert ringing is not None
        return ringing
    weights = [each.clamped_sigma_Hz**-2 for each in balances]
    extension = float(np.mean([each.extension_m for each in balances]))
    clamped = float(np.average([each.clamped_Hz for each in balances], weights=weights))
    lagging = 0.25 * (2.0 * pi * clamped * (together.lag_s if together is not None else 0.0)) ** 2 * clamped
    sigma = hypot(max(float(np.std([each.clamped_Hz for each in balances])), sum(weights) ** -0.5), lagging)
    damping = float(np.mean([own.get(each, nan) for each in balances]))
    ring = (ringing.ring_Hz, ringing.ring_sigma_Hz) if ringing is not None else (nan, nan)
    believed = clamped_Hz(link, link.payload_kg, extension)
    return MapPoint(extension, ring[0], clamped, ring[1], sigma, believed, damping, len(holds))


def _of_holds(link: LinkMode, holds: Sequence[FreeVibration]) -> MapPoint:
    weights = [1.0 / hold.clamped_sigma_Hz**2 for hold in holds]
    extension, ring, clamped, damping = (
        float(np.average([getattr(hold, name) for hold in holds], weights=weights))
        for name in ("extension_m", "frequency_Hz", "clamped_Hz", "damping_ratio")
    )
    noise = float(np.sum(weights)) ** -0.5
    ring_sigma = float(np.std([hold.frequency_Hz for hold in holds])) + NOISE_SHARE * ring
    clamped_sigma = max(float(np.std([hold.clamped_Hz for hold in holds])), noise)
    believed = clamped_Hz(link, link.payload_kg, extension)
    return MapPoint(extension, ring, clamped, ring_sigma, clamped_sigma, believed, damping, len(holds))


def _damping(holds: Sequence[FreeVibration]) -> tuple[float, float]:
    """Mean over the holds that determine it, and two standard deviations of that mean; NaN when none does."""
    known = [(hold.damping_ratio, hold.damping_sigma) for hold in holds if hold.damping_sigma < LARGEST_DAMPING_SIGMA]
    if not known:
        return float("nan"), float("nan")
    values, sigmas = (np.array(column) for column in zip(*known, strict=True))
    mean = float(np.average(values, weights=sigmas**-2.0))
    spread = float(np.average((values - mean) ** 2, weights=sigmas**-2.0)) / max(1, len(known) - 1)
    return mean, 2.0 * float(np.sqrt(max(spread, 1.0 / np.sum(sigmas**-2.0))))
