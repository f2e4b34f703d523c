"""The link's frequency and damping over the extension, from the holds of many moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from config.errors import LogError
from config.rig import LinkMode
from tuning.free_vibration import SMALLEST_MPS2, FreeVibration
from tuning.payload import clamped_Hz

SAME_PLACE_M = 0.01
MODEL_SHARE = 0.002  # of a frequency: what one static shape leaves
NOISE_SHARE = 2e-4  # of a ringing frequency: the fit to a hold of some seconds
LARGEST_DAMPING_SIGMA = 0.01  # holds that know less about damping do not count in its mean


@dataclass(frozen=True, slots=True)
class MapPoint:
    """Frequencies in Hz at one extension: as it rings, of the link alone, and what the rig file's constants say of the link alone.
    Standard deviations: the spread of the holds or what noise explains, whichever is larger."""

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
    with the payload of the rig file, over its own EI."""

    points: tuple[MapPoint, ...]
    damping_ratio: float
    damping_uncertainty: float
    stiffness_ratio: float


def link_map(link: LinkMode, holds: Sequence[FreeVibration]) -> LinkMap:
    """Raises LogError when no hold rings enough."""
    good = sorted(holds, key=lambda hold: hold.extension_m)
    if not good:
        advice = "Use moves without command filter, and end_point.gain: 0 while the map is made."
        raise LogError("the link rings in no hold", limit=f"{SMALLEST_MPS2} and less than 5 % damping", unit="m/s²", next_step=advice)
    places: list[list[FreeVibration]] = []
    for hold in good:
        if places and hold.extension_m - places[-1][0].extension_m < SAME_PLACE_M:
            places[-1].append(hold)
        else:
            places.append([hold])
    points = tuple(_point(link, place) for place in places)
    ratios = [(point.clamped_Hz / point.believed_Hz) ** 2 for point in points]
    weights = [(point.believed_Hz / (point.clamped_sigma_Hz + MODEL_SHARE * point.believed_Hz)) ** 2 for point in points]
    return LinkMap(points, *_damping(good), float(np.average(ratios, weights=weights)))


def _point(link: LinkMode, holds: Sequence[FreeVibration]) -> MapPoint:
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
    """Mean over the holds that know it, and two standard deviations of that mean; NaN when none does."""
    known = [(hold.damping_ratio, hold.damping_sigma) for hold in holds if hold.damping_sigma < LARGEST_DAMPING_SIGMA]
    if not known:
        return float("nan"), float("nan")
    values, sigmas = (np.array(column) for column in zip(*known, strict=True))
    mean = float(np.average(values, weights=sigmas**-2.0))
    spread = float(np.average((values - mean) ** 2, weights=sigmas**-2.0)) / max(1, len(known) - 1)
    return mean, 2.0 * float(np.sqrt(max(spread, 1.0 / np.sum(sigmas**-2.0))))
