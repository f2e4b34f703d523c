"""Time stamps of a clock coarser than the samples: spread onto the regular period of which they are the rounding, where that is certain.

Samples t0 + h i behind a clock of ticks q > h stamp each within one tick of its time, so all stamps lie in a strip of height q about a
straight line over the row's number; a row that was lost, written twice or late beside the others leaves it. How steep the line is, is
known to about q / n for n rows. Where every row with the stamp of the row before is that row again, rows were copied, not measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from recording.importing.parts import SPLIT_S, Columns
from recording.importing.table import Floats

STRIP = 1.1  # ticks: clocks are not quite even themselves, and stamps are written with few decimals
SURELY_FINER = 10  # times what the period is unsure by: a few rows written twice look like samples just finer than the clock
LARGEST_UNSURE = 0.01  # of the period


@dataclass(frozen=True, slots=True)
class RegularPeriod:
    """Rows every `period_s` ± `unsure_s`, stamped with ticks of `tick_s`."""

    period_s: float
    unsure_s: float
    tick_s: float


def spread(columns: Columns) -> tuple[Floats, tuple[str, ...]]:
    """The stamps of all rows of a table (NaN: none), those of each piece between pauses spread where some stand twice and their period is
    certain; and a sentence about each such piece. The first row of a piece keeps its stamp."""
    t_s = columns["t_s"]
    out, said = t_s.copy(), []
    stamped = np.flatnonzero(~np.isnan(t_s))
    steps = np.diff(t_s[stamped])
    edges = [0, *(np.flatnonzero((steps > SPLIT_S) | (steps < 0)) + 1).tolist(), len(stamped)]
    for first, last in pairwise(edges):
        at = stamped[first:last]
        found = regular_period(t_s[at], at - at[0]) if _measured_within_a_tick(columns, at) else None
        if found is not None:
            out[at] = t_s[at[0]] + found.period_s * (at - at[0])
            said.append(_sentence(t_s[at], found, float(np.max(np.abs(out[at] - t_s[at])))))
    return out, tuple(said)


def regular_period(t_s: Floats, row: npt.NDArray[np.int64]) -> RegularPeriod | None:
    """The period of which stamps that don't decrease are the rounding; None where it is not certain. `row`: their numbers, from 0."""
    steps = np.diff(t_s)
    if not np.any(steps > 0):
        return None
    tick_s = float(np.median(steps[steps > 0]))
    period_s = float(np.polynomial.Polynomial.fit(row, t_s - t_s[0], 1).convert().coef[1])
    unsure_s = tick_s / float(row[-1])
    certain = SURELY_FINER * unsure_s <= tick_s - period_s and unsure_s <= LARGEST_UNSURE * period_s
    return RegularPeriod(period_s, unsure_s, tick_s) if certain and np.ptp(t_s - period_s * row) <= STRIP * tick_s else None


def _measured_within_a_tick(columns: Columns, at: npt.NDArray[np.int64]) -> bool:
    """Whether a row with the stamp of the row before it has other numbers."""
    again = np.diff(columns["t_s"][at]) == 0
    before, row = at[:-1][again], at[1:][again]
    return any(not np.array_equal(values[before], values[row], equal_nan=True) for values in columns.values())


def _sentence(t_s: Floats, found: RegularPeriod, moved_s: float) -> str:
    span, twice = f"{t_s[0]:.6g} to {t_s[-1]:.6g} s", int(np.sum(np.diff(t_s) == 0))
    seen = f"The clock is coarse ({span}): {twice} of {len(t_s)} rows have the stamp of the row before, in steps of {_ms(found.tick_s)}."
    period = f"{_ms(found.period_s)} (± {1e3 * found.unsure_s:.2g} ms)"
    return f"{seen} They round one period of {period}, onto which the rows are spread, by {1e3 * moved_s:.2g} ms at most."


def _ms(value_s: float) -> str:
    return f"{1e3 * value_s:.5g} ms"
