"""A fault, what must come of it and within which time; and what came of it, trial by trial."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from math import inf, isfinite, nan
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


class FaultPlace(StrEnum):
    """Where a fault is injected, and so what it takes to measure it."""

    LOOP = "loop"  # the daemon's own loop in lockstep
    PROCESSES = "processes"  # a daemon on the wall clock with the plant in its own process
    TWIN = "twin"  # a daemon on the wall clock with devices behind CAN and Modbus


@dataclass(frozen=True, slots=True)
class FaultTrial:
    """One injection. `time_ms` is infinite when what was waited for did not come about."""

    time_ms: float
    reaction: str
    reacted_ms: float | None = None  # by the loop's own account, when its reaction began


@dataclass(frozen=True, slots=True)
class Expected:
    """What must come of a fault: a reaction that contains this text, and the end that is waited for within `limit_ms`."""

    reaction: str
    until: Until
    limit_ms: float


@dataclass(frozen=True, slots=True)
class Fault:
    """`run(chance, directory)` makes one trial. `limit_ms` is for the time; `began_limit_ms`, where
    it is given, for the beginning of the reaction."""

    name: str
    group: str
    expected: Expected
    run: Callable[[Random, Path], FaultTrial]
    where: FaultPlace = FaultPlace.LOOP
    impossible: str = ""  # why it cannot be injected here; then it is skipped
    began_limit_ms: float | None = None


@dataclass(slots=True)
class FaultRow:
    """All trials of one fault. Ok: every one of them had the expected reaction within the limits.

    `by_median`: more than half of them had, and the median time is within the limit; for a machine that others use too.
    """

    fault: Fault
    trials: list[FaultTrial] = field(default_factory=list)
    by_median: bool = False

    @property
    def skipped(self) -> bool:
        return bool(self.fault.impossible)

    @property
    def reaction(self) -> str:
        """That of the first trial that went wrong, else of the first."""
        if self.skipped:
            return f"skipped: {self.fault.impossible}"
        wrong = [trial for trial in self.trials if self.fault.expected.reaction not in trial.reaction]
        return (wrong or self.trials)[0].reaction

    @property
    def median_ms(self) -> float:
        return statistics.median(trial.time_ms for trial in self.trials) if self.trials else nan

    @property
    def worst_ms(self) -> float:
        return max((trial.time_ms for trial in self.trials), default=nan)

    @property
    def worst_reacted_ms(self) -> float | None:
        known = [trial.reacted_ms for trial in self.trials if trial.reacted_ms is not None]
        return max(known) if known else None

    @property
    def ok(self) -> bool:
        good = sum(map(self._is_good, self.trials))
        return self.skipped or (2 * good > len(self.trials) if self.by_median else good == len(self.trials) > 0)

    def _is_good(self, trial: FaultTrial) -> bool:
        limit = self.fault.began_limit_ms
        began = limit is None or (trial.reacted_ms is not None and trial.reacted_ms <= limit)
        expected = self.fault.expected
        return expected.reaction in trial.reaction and began and trial.time_ms <= expected.limit_ms

    def as_dict(self) -> dict[str, Any]:
        """As `--json` prints it; a time that never came is null."""
        return {
            "fault": self.fault.name,
            "group": self.fault.group,
            "where": str(self.fault.where),
            "reaction": self.reaction,
            "until": str(self.fault.expected.until),
            "time_to_safe_ms": {"median": _finite(self.median_ms), "worst": _finite(self.worst_ms)},
            "reaction_began_ms": self.worst_reacted_ms,
            "limit_ms": self.fault.expected.limit_ms,
            "trials": len(self.trials),
            "skipped": self.skipped,
            "ok": self.ok,
        }


def _finite(time_ms: float) -> float | None:
    return round(time_ms, 3) if isfinite(time_ms) else None


NEVER_MS = inf
