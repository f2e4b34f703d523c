"""Where the playing of a log is, and every row up to there as the loop's facts."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from config.errors import UsageError
from daemon.checks.interlocks import rig_facts
from recording.files.info import RunFacts, require_cycles, run_facts
from recording.files.reader import Log, open_rig

_FIRST, _LAST = 0.01, 1000.0  # of the speed


class LogPlayer:
    """`speed`: seconds of the log a second. It begins at `from_s`, seconds after the log's first row, when it is first asked, and
    stays at the last row.

    LogError for a log without rows or rig file, UsageError for a speed or a moment that cannot be.
    """

    def __init__(self, log: Log, speed: float = 1.0, from_s: float = 0.0, clock: Callable[[], float] = time.monotonic) -> None:
        require_cycles(log)
        if not _FIRST <= speed <= _LAST:
            mend = {"--speed": f"{min(max(speed, _FIRST), _LAST):g}"}
            raise UsageError("this is no speed", value=speed, limit=f"{_FIRST:g} to {_LAST:g}", where="--speed", mend=mend)
        if not 0.0 <= from_s <= log.duration_s:
            limit, mend = f"0 to {log.duration_s:.3f}", {"--from": "0"}
            raise UsageError("the moment is outside the log", value=from_s, limit=limit, unit="s", where="--from", mend=mend)
        self.log, self.rig = log, open_rig(log)
        self.facts = rig_facts(self.rig)
        self.runs: dict[int, RunFacts] = {run.number: run for run in run_facts(log)}
        self._t = log.columns["t_s"]
        self._speed, self._clock, self._start_s = speed, clock, float(self._t[0]) + from_s
        self._begun: float | None = None
        missing = np.full(log.cycles, np.nan)
        self._columns = [log.columns.get(name, missing) for name in self.facts.names[: self.facts.row_length]]
        self._errors = [tuple(self.facts.index(f"{joint}.{word}") for word in _FOLLOWING) for joint in self.rig.joints]

    def row_now(self) -> int:
        """Number of the row that would be the newest now."""
        if self._begun is None:
            self._begun = self._clock()
        return self.row_at(self._start_s + self._speed * (self._clock() - self._begun))

    def row_at(self, t_s: float) -> int:
        """Of the last row not after `t_s`; the first one before all."""
        return max(0, int(np.searchsorted(self._t, t_s, side="right")) - 1)

    def values(self, row: int) -> list[float]:
        """The facts of that row; those that no column holds are as before anything was measured, but for the run's."""
        values = self.facts.blank()
        values[: self.facts.row_length] = [float(column[row]) for column in self._columns]
        for error, reference, position in self._errors:
            values[error] = abs(values[reference] - values[position])
        begun = [run for run in self.runs.values() if run.start_t_s <= self._t[row]]
        if begun:
            elapsed_s = min(float(self._t[row]) - begun[-1].start_t_s, begun[-1].duration_s)
            for name, value in (("number", begun[-1].number), ("elapsed_s", elapsed_s), ("duration_s", begun[-1].duration_s)):
                values[self.facts.index(f"run.{name}")] = float(value)
        return values


_FOLLOWING = ("following_error", "reference", "position")
