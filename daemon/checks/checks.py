"""Named checks. A check is a number of the facts and the limits it must lie in; the same object refuses arming and trips in the loop."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import inf, isfinite
from typing import Any


class Reaction(StrEnum):
    """What a failed check does while armed, most severe first. All but the last refuse arming."""

    FAULT = "fault"  # safe outputs at once, latched
    STOP_THEN_FAULT = "controlled stop, then fault"
    STOP = "controlled stop"
    REFUSE = "refuses arming"  # and nothing while armed
    WARN = "warning"  # shown by `why` and logged at arming


@dataclass(frozen=True, slots=True)
class Check:
    """`index`: of the number in the facts; it must lie in [low, high], which no NaN does. `unit`: of number and limits.

    `next_step`: what to do, with the command to type. `page`: where it is explained.
    """

    name: str
    index: int
    low: float
    high: float
    unit: str
    source: str
    reaction: Reaction
    next_step: str
    age_index: int | None = None
    page: str = ""

    def passes(self, values: Sequence[float]) -> bool:
        return self.low <= values[self.index] <= self.high

    @property
    def limit(self) -> str:
        if self.low == self.high:
            return f"{self.low:.4g}"
        if self.low == -inf:
            return f"≤ {self.high:.6g}"
        return f"≥ {self.low:.6g}" if self.high == inf else f"{self.low:.6g} to {self.high:.6g}"

    def row(self, values: Sequence[float]) -> dict[str, Any]:
        """What `longreach why` shows."""
        age = values[self.age_index] if self.age_index is not None else None
        return {
            "name": self.name,
            "ok": self.passes(values) or self.reaction is Reaction.WARN,
            "value": values[self.index],
            "limit": self.limit,
            "unit": self.unit,
            "source": self.source,
            "age_s": age,
            "severity": self._severity(values),
            "reaction": str(self.reaction),
            "next_step": self.next_step,
            "page": self.page,
        }

    def _severity(self, values: Sequence[float]) -> str:
        if self.reaction is not Reaction.WARN:
            return "error"
        return "info" if self.passes(values) else "warning"

    def sentence(self, values: Sequence[float]) -> str:
        """Name, value, limit, unit, source and what to do, for events and refusals."""
        value = values[self.index]
        unit = f" {self.unit}" if self.unit else ""
        shown = f"{value:.6g}{unit}" if isfinite(value) else "no valid value"
        return f"{self.name} ({self.source}): {shown} (limit {self.limit}{unit}). {self.next_step}"


class CheckGroup:
    """Checks with one reaction, ready for the loop: a flat walk over numbers, about 0.1 us a check."""

    def __init__(self, checks: Iterable[Check]) -> None:
        self.checks = tuple(checks)
        self._limits = tuple((check.index, check.low, check.high) for check in self.checks)

    def first_failed(self, values: Sequence[float]) -> Check | None:
        """The first check that does not pass, in their order, or None."""
        for index, low, high in self._limits:
            if not low <= values[index] <= high:
                return next(check for check in self.checks if not check.passes(values))
        return None

    def failed(self, values: Sequence[float]) -> list[Check]:
        """Every check that does not pass."""
        return [check for check in self.checks if not check.passes(values)]
