"""The signals of two logs side by side on the cycles of the first, and what could not be put side by side.

B is put on A's cycles by straight lines between its own, never across a missing number or lost cycles: what was there is not known.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from config.stated_sentences import Conversion
from recording.evaluation.chosen_signals import DEVICE_ENDINGS, ChosenSignal, column_conversions, in_unit
from recording.evaluation.program_start import plan_of, program_start_s
from recording.files.info import require_cycles, run_of
from recording.files.reader import Log
from recording.format.fields import CYCLE_FIELDS

_LOOP = {entry.name for entry in CYCLE_FIELDS}
_SAME_S = 1e-9  # moments closer than this are the same

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class NotCompared:
    """`only_a`, `only_b`: signals with numbers in one log alone. `rows`: of a signal, those in which one log alone has a number.
    `cycles`: how many of the common time A and B lost."""

    only_a: tuple[str, ...]
    only_b: tuple[str, ...]
    rows: dict[str, int]
    cycles: tuple[int, int]

    def __bool__(self) -> bool:
        return bool(self.only_a or self.only_b or self.rows or any(self.cycles))

    def lines(self) -> list[str]:
        only = [f"only in {log}: {', '.join(names)}" for log, names in (("A", self.only_a), ("B", self.only_b)) if names]
        lost = [f"not compared: {count} cycles that {log} lost" for log, count in zip("AB", self.cycles, strict=True) if count]
        return [*only, *lost, *(f"not compared: {name} in {count} rows, NaN in one log" for name, count in self.rows.items())]


@dataclass(frozen=True, slots=True)
class CommonTime:
    """`rows` of A lie in the time since the program began that both logs have; `time_s` is that time, `zero_b_s` where it is 0 in B's
    t_s."""

    rows: npt.NDArray[np.bool_]
    time_s: Floats
    zero_b_s: float
    cycles_lost: tuple[int, int]

    @property
    def length_s(self) -> float:
        return float(self.time_s[-1] - self.time_s[0]) if len(self.time_s) else 0.0


def common_time(a: Log, b: Log, runs: tuple[int, int]) -> CommonTime:
    """Of one run each; 0 for all of a log. LogError for a run that a log does not have."""
    (start_a, end_a, zero_a), (start_b, end_b, zero_b) = _span(a, runs[0]), _span(b, runs[1])
    first_s, last_s = max(start_a - zero_a, start_b - zero_b), min(end_a - zero_a, end_b - zero_b)
    time = a.columns["t_s"] - zero_a
    rows = (time >= first_s - _SAME_S) & (time <= last_s + _SAME_S) & ~_in_holes(b, time + zero_b)
    lost = _lost(a, first_s + zero_a, last_s + zero_a), _lost(b, first_s + zero_b, last_s + zero_b)
    return CommonTime(rows, time[rows], zero_b, lost)


def aligned_signals(a: Log, b: Log, common: CommonTime, si: bool) -> tuple[dict[str, tuple[ChosenSignal, ChosenSignal]], NotCompared]:
    """Of every signal the rows in which both have a number, in the units of A's rig file; and what else there is."""
    pairs, rows, only_a, only_b = {}, {}, [], []
    for name, mine, other in _side_by_side(a, b, common, {} if si else column_conversions(a)):
        in_a, in_b = np.isfinite(mine.values), np.isfinite(other.values)
        both = in_a & in_b
        if both.any():
            pairs[name] = _chosen(mine, both), _chosen(other, both)
            rows[name] = int(np.sum(in_a != in_b))
        elif in_a.any() or in_b.any():
            only_a += [name] if in_a.any() else []
            only_b += [name] if in_b.any() else []
    return pairs, NotCompared(tuple(only_a), tuple(only_b), {name: count for name, count in rows.items() if count}, common.cycles_lost)


def _side_by_side(a: Log, b: Log, common: CommonTime, units: Mapping[str, Conversion]) -> Iterator[tuple[str, ChosenSignal, ChosenSignal]]:
    for name in dict.fromkeys([*a.columns, *b.columns]):
        if name in _LOOP or name.endswith(DEVICE_ENDINGS):
            continue
        mine, other = (in_unit(log, name, slice(None), units) if name in log.columns else None for log in (a, b))
        unit = next(signal.unit for signal in (mine, other) if signal is not None)
        none = np.full(len(common.time_s), np.nan)
        on_a = none if other is None else np.interp(common.time_s, other.t_s - common.zero_b_s, other.values)
        of_a = none if mine is None else mine.values[common.rows]
        yield name, ChosenSignal(name, unit, common.time_s, of_a), ChosenSignal(name, unit, common.time_s, on_a)


def _chosen(signal: ChosenSignal, rows: npt.NDArray[np.bool_]) -> ChosenSignal:
    return ChosenSignal(signal.name, signal.unit, signal.t_s[rows], signal.values[rows])


def _span(log: Log, run: int) -> tuple[float, float, float]:
    """Start, end, and where the program begins."""
    require_cycles(log)
    t = log.columns["t_s"]
    if run == 0:
        return float(t[0]), float(t[-1]), float(t[0])
    found = run_of(log, run)
    return found.start_t_s, found.start_t_s + found.duration_s, program_start_s(log, run, plan_of(log, run))


def _before_holes(log: Log) -> npt.NDArray[np.intp]:
    """The rows after which cycles are missing."""
    return np.flatnonzero(np.diff(log.columns["cycle"].astype(np.int64)) > 1)


def _in_holes(log: Log, t_s: Floats) -> npt.NDArray[np.bool_]:
    """Which moments lie between two cycles of the log that do not follow each other."""
    t, holes = log.columns["t_s"], _before_holes(log)
    before = np.searchsorted(t[holes] + _SAME_S, t_s) - 1
    after = np.append(t[holes + 1], -np.inf)[before]  # before the first hole: index -1, in none
    return np.asarray(t_s < after - _SAME_S)


def _lost(log: Log, first_t_s: float, last_t_s: float) -> int:
    """How many cycles are missing between these moments."""
    t, cycle, holes = log.columns["t_s"], log.columns["cycle"].astype(np.int64), _before_holes(log)
    inside = holes[(t[holes + 1] > first_t_s) & (t[holes] < last_t_s)]
    return int(np.sum(cycle[inside + 1] - cycle[inside] - 1))
