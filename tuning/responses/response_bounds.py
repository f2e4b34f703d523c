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
    """Of one joint excited one way: lowest and highest magnitude (dB of rad or m per V) and phase (degrees) of the responses among which
    only `varied` differs."""

    joint: str
    on: str
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

    @property
    def family(self) -> str:
        return f"{self.joint}, {self.on}"


def bounds(responses: Sequence[FrequencyResponse]) -> list[Bounds]:
    """For each joint and what was excited, one entry for every condition that was varied alone, and one over all (`all`); multisines
    where there are any, else sweeps."""
    families: dict[tuple[str, str], list[FrequencyResponse]] = {}
    for each in responses:
        families.setdefault((each.conditions.joint, each.conditions.on), []).append(each)
    return [entry for family in families.values() for entry in _of_family(family)]


def _of_family(responses: Sequence[FrequencyResponse]) -> list[Bounds]:
    best = [each for each in responses if each.source == "multisine"] or list(responses)
    groups = [(name, max((_alone(best, base, name) for base in best), key=len)) for name in VARIED]
    found = [_bounds(name, group) for name, group in (*groups, ("all", best)) if len(group) > 1]
    return [each for each in found if each is not None]


def _alone(responses: Sequence[FrequencyResponse], base: FrequencyResponse, varied: str) -> list[FrequencyResponse]:
    """The base and the responses that differ from it in `varied` and in nothing else."""
    return [each for each in responses if each is base or _differing(each, base) == {varied}]


def _differing(response: FrequencyResponse, base: FrequencyResponse) -> set[str]:
    """In what conditions two responses differ; what was not measured (NaN) does not."""
    here, there = response.conditions, base.conditions
    return {name for name in VARIED if abs(getattr(here, name) - getattr(there, name)) > SAME[name]}


def _bounds(varied: str, responses: Sequence[FrequencyResponse]) -> Bounds | None:
    low, high = max(each.frequencies_Hz[0] for each in responses), min(each.frequencies_Hz[-1] for each in responses)
    if low >= high:
        return None
    grid = np.geomspace(low, high, POINTS)
    magnitude = np.array([np.interp(grid, each.frequencies_Hz, 20.0 * np.log10(np.abs(each.response))) for each in responses])
    phase = np.array([np.interp(grid, each.frequencies_Hz, np.degrees(np.unwrap(np.angle(each.response)))) for each in responses])
    phase -= 360.0 * np.round((phase[:, :1] - phase[0, 0]) / 360.0)
    levels, angles = (magnitude.min(axis=0), magnitude.max(axis=0)), (phase.min(axis=0), phase.max(axis=0))
    at = responses[0].conditions
    return Bounds(at.joint, at.on, varied, len(responses), grid, levels, angles)
