"""How far responses at different conditions lie apart (Figures 3 to 5 of the paper): the plant's bounds for a design."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tuning.arrays import Floats
from tuning.responses.frequency_response import FrequencyResponse

POINTS = 40
VARIED = ("amplitude", "extension_m", "position", "oil_C", "payload_kg")
SAME = {"amplitude": 1e-3, "extension_m": 0.02, "position": 0.02, "oil_C": 2.0, "payload_kg": 0.05}


@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """Lowest and highest magnitude (dB of rad or m per V) and phase (degrees) of the responses among which only `varied` differs."""

    varied: str
    count: int
    frequencies_Hz: Floats
    magnitude_dB: tuple[Floats, Floats]
    phase_deg: tuple[Floats, Floats]

    @property
    def spread(self) -> tuple[float, float]:
        """Largest distance over the band, dB and degrees."""
        low, high = self.magnitude_dB
        lag, lead = self.phase_deg
        return float(np.max(high - low)), float(np.max(lead - lag))


def bounds(responses: Sequence[FrequencyResponse]) -> list[Bounds]:
    """One entry for every condition that was varied alone, and one over all (`all`); multisines where there are any, else sweeps."""
    best = [each for each in responses if each.source == "multisine"] or list(responses)
    groups = [(name, max(([each for each in best if _alone(each, base, name)] for base in best), key=len, default=[])) for name in VARIED]
    found = [_bounds(name, group) for name, group in (*groups, ("all", best))]
    return [each for each in found if each is not None and each.count > 1]


def _alone(response: FrequencyResponse, base: FrequencyResponse, varied: str) -> bool:
    """Whether nothing but `varied` differs; what was measured on neither (NaN) does not."""
    here, there = response.conditions, base.conditions
    return not any(abs(getattr(here, name) - getattr(there, name)) > SAME[name] for name in VARIED if name != varied)


def _bounds(varied: str, responses: Sequence[FrequencyResponse]) -> Bounds | None:
    if not responses:
        return None
    low, high = max(each.frequencies_Hz[0] for each in responses), min(each.frequencies_Hz[-1] for each in responses)
    if low >= high:
        return None
    grid = np.geomspace(low, high, POINTS)
    magnitude = np.array([np.interp(grid, each.frequencies_Hz, 20.0 * np.log10(np.abs(each.response))) for each in responses])
    phase = np.array([np.interp(grid, each.frequencies_Hz, np.degrees(np.unwrap(np.angle(each.response)))) for each in responses])
    phase -= 360.0 * np.round((phase[:, :1] - phase[0, 0]) / 360.0)
    return Bounds(varied, len(responses), grid, (magnitude.min(axis=0), magnitude.max(axis=0)), (phase.min(axis=0), phase.max(axis=0)))
