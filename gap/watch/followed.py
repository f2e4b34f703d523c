"""One number over all logs, held against its limits: what it is now, how it changes, whether it has gone too far."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import numpy as np
from scipy.stats import norm

from gap.watch.course import LEAST_P, Course, course
from gap.watch.dated_logs import DatedLog
from gap.watch.limits import NumberLimits
from gap.watch.log_fit import FittedValue, LogFit
from gap.watch.watched import Watched

LEAST_LOGS = 4  # that tell a number, for anything to be said about its course
AS_WIDE = 0.5  # of its (wide) prior standard deviation: a number known no better is said to be unknown
DAY_S = 86400.0
_TWO_SIDED = float(norm.ppf(0.975))


@dataclass(frozen=True, slots=True)
class Followed:
    """`logs` and `values` in the order of time. `course`: None with too few logs, or where they do not tell the number."""

    number: Watched
    limits: NumberLimits
    logs: tuple[DatedLog, ...]
    values: tuple[FittedValue, ...]
    course: Course | None

    @property
    def now(self) -> tuple[float, float]:
        """At the last log, with its 95 % half width: what is equally wrong in all logs is in it."""
        assert self.course is not None
        value, sd = self.course.now
        common = float(np.average([max(v.sd**2 - v.again_sd**2, 0.0) for v in self.values], weights=self.course.fit.weights))
        return value, float(np.hypot(self.course.fit.times_sd() * sd, _TWO_SIDED * np.sqrt(common)))

    @property
    def alarm(self) -> bool:
        """Whether the whole interval lies beyond a limit."""
        if self.course is None:
            return False
        value, width = self.now
        return value - width > self.limits.high or value + width < self.limits.low

    @property
    def limit_in_days(self) -> float | None:
        """From the last log until a number that drifts reaches the limit ahead of it; None where it does not, or is there already."""
        if self.course is None or not self.course.drifts:
            return None
        slope, (value, _) = self.course.slope[0], self.now
        ahead = (self.limits.high if slope > 0.0 else self.limits.low) - value
        return ahead / slope if math.isfinite(ahead) and ahead / slope > 0.0 else None

    @property
    def word(self) -> str:
        """What it does, in a word or two."""
        if self.course is None:
            return "unknown" if len(self.logs) >= LEAST_LOGS or not self.logs else f"{len(self.logs)} of {LEAST_LOGS} logs"
        told = (["drifts"] if self.course.drifts else []) + (["steps"] if self.course.steps else [])
        return " and ".join(told) or "steady"

    def as_dict(self) -> dict[str, Any]:
        """SI; times in days and UTC."""
        free = self.number.free
        rows = [
            {"log": log.path.name, "begun_utc": log.begun.isoformat(), **_interval(v.value, _TWO_SIDED * v.sd), "again_sd": v.again_sd}
            for log, v in zip(self.logs, self.values, strict=True)
        ]
        limits = [value if math.isfinite(value) else None for value in (self.limits.low, self.limits.high)]
        about = {"constant": free.key, "unit": free.unit, "stated": free.start, "prior_sd": free.scale, "limits": limits}
        return {**about, "course": self.word, "alarm": self.alarm, **self._course(), "logs": rows}

    def _course(self) -> dict[str, Any]:
        if self.course is None:
            return {"now": None, "trend_per_day": None, "steps": [], "scatter_sd": None, "limit_in_days": None}
        steps = [
            {"log": self.logs[first].path.name, "begun_utc": self.logs[first].begun.isoformat(), **_interval(*self.course.step(k), "by")}
            for k, first in enumerate(self.course.steps)
        ]
        found = {"now": _interval(*self.now), "trend_per_day": _interval(*self.course.slope), "steps": steps}
        return {**found, "scatter_sd": self.course.fit.between_sd, "limit_in_days": self.limit_in_days}


def followed(numbers: Sequence[Watched], limits: Mapping[str, NumberLimits], fits: Sequence[tuple[DatedLog, LogFit]]) -> list[Followed]:
    """Every number over the logs that tell it; `fits` in the order of time."""
    seen = {n.name: [(log, fit.values[n.name]) for log, fit in fits if n.name in fit.values] for n in numbers}
    least_p = LEAST_P / max(sum(len(rows) >= LEAST_LOGS for rows in seen.values()), 1)
    return [_one(n, limits[n.name], seen[n.name], least_p) for n in numbers]


def _days_of(begun: Sequence[datetime]) -> np.ndarray:
    """Since the first."""
    return np.array([(moment - begun[0]).total_seconds() / DAY_S for moment in begun])


def _one(number: Watched, limits: NumberLimits, rows: Sequence[tuple[DatedLog, FittedValue]], least_p: float) -> Followed:
    logs, values = tuple(log for log, _ in rows), tuple(value for _, value in rows)
    alone = Followed(number, limits, logs, values, None)
    if len(rows) < LEAST_LOGS or logs[0].begun == logs[-1].begun:
        return alone
    found = course(
        _days_of([log.begun for log in logs]), np.array([v.value for v in values]), np.array([v.again_sd for v in values]), least_p
    )
    whole = Followed(number, limits, logs, values, found)
    return whole if whole.now[1] <= _TWO_SIDED * AS_WIDE * number.wide.scale else alone


def _interval(value: float, width: float, name: str = "value") -> dict[str, Any]:
    """JSON has no infinity: an interval without end is None."""
    return {name: value, "ci95": [value - width, value + width] if math.isfinite(width) else None}
