"""What is proposed to be run next: a maneuver, how well it tells each pair of explanations apart, and the sensor it needs, if any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gap.maneuvers.designs import ManeuverDesign
from gap.maneuvers.extra_sensor import ExtraSensor
from gap.maneuvers.separation import Separation

LEAST_SEPARATION = 9.0  # below this the two are the same to the maneuver, whatever is fitted
WANTED_T = 5.0
MOST_REPEATS = 10


@dataclass(frozen=True, slots=True)
class Pair:
    """Two explanations and what one maneuver says about them."""

    names: tuple[str, str]
    separation: Separation

    @property
    def repeats(self) -> int | None:
        """Runs needed for t > 5; None when that is too many, or the two are the same to the maneuver."""
        if self.separation.T < LEAST_SEPARATION or self.separation.t <= 0.0:
            return None
        needed = int(np.ceil((WANTED_T / self.separation.t) ** 2))
        return needed if needed <= MOST_REPEATS else None

    def as_dict(self) -> dict[str, Any]:
        told = self.separation
        return {"between": list(self.names), "expected_t": round(told.t, 2), "T": round(told.T, 2), "repeats": self.repeats}


@dataclass(frozen=True, slots=True)
class Proposal:
    """One maneuver and how well it would separate every pair; `sensor`: only with these channels fitted."""

    design: ManeuverDesign
    pairs: tuple[Pair, ...]
    duration_s: float
    sensor: ExtraSensor | None = None

    @property
    def told(self) -> list[Pair]:
        """The pairs it separates."""
        return [pair for pair in self.pairs if pair.repeats]

    @property
    def left(self) -> list[Pair]:
        """The pairs it leaves open."""
        return [pair for pair in self.pairs if not pair.repeats]

    @property
    def repeats(self) -> int | None:
        """Runs needed for t > 5 of all pairs that it separates; None when it separates none."""
        return max((pair.repeats or 0 for pair in self.told), default=None)

    @property
    def time_s(self) -> float:
        """Until t > 5 of all pairs that it separates; infinite when there are none."""
        return self.duration_s * self.repeats if self.repeats else np.inf

    @property
    def least(self) -> Separation:
        """Of the pair that is hardest to tell among those it separates, else of the pair that comes nearest to it."""
        separations = [pair.separation for pair in self.told]
        if separations:
            return min(separations, key=lambda item: item.t)
        return max((pair.separation for pair in self.pairs), key=lambda item: (item.t, item.T))

    @property
    def rank(self) -> tuple[int, float, float]:
        """Fewest pairs left open first, then the shortest time, then the clearest."""
        return len(self.left), self.time_s, -self.least.t

    @property
    def why(self) -> str:
        them = "the two" if len(self.pairs) == 1 else "any of them"
        if self.repeats is None:
            return f"no maneuver and no other sensor separates {them} (t {self.least.t:.1f} at best); {self._advice}"
        expected = f"expected t {self.least.t:.1f} in {self.duration_s:.0f} s, {_runs(self.repeats)}"
        if self.left:
            expected += f"; leaves open {'; '.join(' or '.join(pair.names) for pair in self.left)}"
        return f"only another sensor separates {them}: with {self.sensor.text}, {expected}" if self.sensor else expected

    @property
    def _advice(self) -> str:
        if all(" at sensor:" in name for name in _names(self.pairs)):
            return "hold these sensors against something known: a distance, a weight, a gauge"
        return "change the payload or the oil"

    def as_dict(self) -> dict[str, Any]:
        return {
            "name": self.design.name,
            "parameters": dict(self.design.parameters),
            "why": self.why,
            "expected_t": round(self.least.t, 2),
            "T": round(self.least.T, 2),
            "separates": _names(self.told or self.pairs),
            "pairs": [pair.as_dict() for pair in self.pairs],
            "duration_s": round(self.duration_s, 2),
            "repeats": self.repeats,
            "sensor": list(self.sensor.channels) if self.sensor else None,
        }


def _runs(repeats: int) -> str:
    return "one run" if repeats == 1 else f"needs {repeats} repeats for t > {WANTED_T:g}"


def _names(pairs: Sequence[Pair]) -> list[str]:
    """Every explanation of these pairs once."""
    return list(dict.fromkeys(name for pair in pairs for name in pair.names))
