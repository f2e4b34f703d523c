"""A fault, what must come of it and within which time; and what came of it, trial by trial."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from math import inf, isfinite
from pathlib import Path
from random import Random
from typing import Any

SEEN_MS = 20.0  # a fault that the loop sees
INFERRED_MS = 100.0  # one that only the motion shows, after the arm should have moved a share of its following error limit


class Until(StrEnum):
    """What the time is measured to, from the injection on."""

    SAFE = "outputs safe"  # every output has its safe value, and keeps it
    REST = "arm at rest"  # a controlled stop has ended and the servo holds
    RENEWED = "outputs renewed"  # nothing had to be made safe: the longest time for which the outputs were not renewed


@dataclass(frozen=True, slots=True)
class Trial:
    """One injection. `time_ms` is infinite when what was waited for did not come about."""

    time_ms: float
    reaction: str
    reacted_ms: float | None = None  # by the loop's own account, when its reaction began


@dataclass(frozen=True, slots=True)
class Fault:
    """`expected` stands in the reaction; `run(chance, directory)` makes one trial. `limit_ms` is for the time; `began_limit_ms`, where
    it is given, for the beginning of the reaction."""

    name: str
    group: str
    expected: str
    until: Until
    limit_ms: float
    run: Callable[[Random, Path], Trial]
    process: bool = False  # needs real processes, seconds a trial
    began_limit_ms: float | None = None


@dataclass(slots=True)
class Row:
    """All trials of one fault. Ok: every one of them had the expected reaction within the limits."""

    fault: Fault
    trials: list[Trial] = field(default_factory=list)

    @property
    def reaction(self) -> str:
        """That of the first trial that went wrong, else of the first."""
        wrong = [trial for trial in self.trials if self.fault.expected not in trial.reaction]
        return (wrong or self.trials)[0].reaction

    @property
    def median_ms(self) -> float:
        return statistics.median(trial.time_ms for trial in self.trials)

    @property
    def worst_ms(self) -> float:
        return max(trial.time_ms for trial in self.trials)

    @property
    def worst_reacted_ms(self) -> float | None:
        known = [trial.reacted_ms for trial in self.trials if trial.reacted_ms is not None]
        return max(known) if known else None

    @property
    def ok(self) -> bool:
        expected = all(self.fault.expected in trial.reaction for trial in self.trials)
        return expected and self._began_in_time and self.worst_ms <= self.fault.limit_ms

    @property
    def _began_in_time(self) -> bool:
        limit, began = self.fault.began_limit_ms, self.worst_reacted_ms
        return limit is None or (began is not None and began <= limit)

    def as_dict(self) -> dict[str, Any]:
        """As `--json` prints it; a time that never came is null."""
        return {
            "fault": self.fault.name,
            "group": self.fault.group,
            "reaction": self.reaction,
            "until": str(self.fault.until),
            "time_to_safe_ms": {"median": _finite(self.median_ms), "worst": _finite(self.worst_ms)},
            "reaction_began_ms": self.worst_reacted_ms,
            "limit_ms": self.fault.limit_ms,
            "trials": len(self.trials),
            "ok": self.ok,
        }


def _finite(time_ms: float) -> float | None:
    return round(time_ms, 3) if isfinite(time_ms) else None


NEVER_MS = inf
