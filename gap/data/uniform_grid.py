"""Rows of a log on a uniform time grid, and what of it is lost."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from config.errors import LogError

Array = NDArray[np.float64]
BRIDGED_ROWS = 3  # lost rows in a row over which a straight line is drawn; the plant moves on its own in longer gaps
SHORTEST_PERIOD_S = 1e-4
UNEVEN = 0.05  # of the period: samples further off the grid are moved onto it
LEAST_ROWS = 100
MOST_MISSING = 0.5  # share of the grid without a row, above which the rate itself is in doubt


@dataclass(frozen=True, slots=True)
class Grid:
    """Where the rows of a log stand on its grid. `keep`: rows of the log that are used; `place`: their rows on the grid; `instants_s`: when
    every row of the log should have been sampled."""

    start_s: float
    period_s: float
    rows: int
    keep: NDArray[np.bool_]
    place: NDArray[np.int64]
    instants_s: Array

    @property
    def t_s(self) -> Array:
        return self.start_s + self.period_s * np.arange(self.rows, dtype=np.float64)

    def on(self, column: Array) -> Array:
        """A column of the log on the grid, NaN where it has no row."""
        values = np.full(self.rows, np.nan)
        values[self.place] = column[self.keep]
        return values

    def jitter_s(self, t: Array) -> float:
        """Largest distance of a used row from its instant; `t`: times of the log's rows, s."""
        return float(np.max(np.abs((t - self.instants_s)[self.keep])))

    def missing(self) -> NDArray[np.bool_]:
        """Rows of the grid in gaps too long to bridge."""
        missing = np.ones(self.rows, dtype=np.bool_)
        missing[self.place] = False
        for start, length in runs(missing):
            missing[start : start + length] = length > BRIDGED_ROWS
        return missing


def grid_of(path: Path, t: Array) -> Grid:
    """The grid of the mean period of times `t`, s. LogError for a log that is sampled too fast or at no steady rate."""
    period = _period(t)
    if period < SHORTEST_PERIOD_S * (1 - UNEVEN):
        advice = "Keep every second (third …) row: the simulation's delay lines hold 0.1 s at up to 10 kHz."
        raise LogError("the log is sampled too fast", value=round(1 / period), limit=10_000, unit="Hz", where=str(path), next_step=advice)
    index = np.round((t - t[0]) / period).astype(np.int64)
    keep = np.concatenate([[True], np.diff(np.maximum.accumulate(index)) > 0])
    rows = int(index[keep][-1]) + 1
    if keep.sum() < (1 - MOST_MISSING) * rows:
        lost, advice = f"{1 - keep.sum() / rows:.0%} of the rows", f"Give data with one sampling rate; a part that has one: {path}@FROM:TO."
        raise LogError("the log has no steady rate", value=lost, limit="50%", where=str(path), next_step=advice)
    return Grid(float(t[0]), period, rows, keep, index[keep], t[0] + index * period)


def _period(t: Array) -> float:
    """Mean period of the rows. The median step alone is off by its own jitter, which adds up over a log; a line through row number and
    time is not."""
    steps = np.diff(t)
    guess = float(np.median(steps[steps > 0]))
    number = np.concatenate([[0.0], np.cumsum(np.round(np.maximum(steps, 0.0) / guess))])
    return float(np.polyfit(number - number.mean(), t - t.mean(), 1)[0])


def bridged(values: Array) -> Array:
    """Values with a straight line over at most BRIDGED_ROWS lost ones; NaN stays in longer gaps."""
    lost = np.isnan(values)
    rows = np.arange(len(values))
    filled = np.interp(rows, rows[~lost], values[~lost]) if not lost.all() else values.copy()
    for start, length in runs(lost):
        if length > BRIDGED_ROWS:
            filled[start : start + length] = np.nan
    return np.asarray(filled)


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Start and length of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(start), int(end - start)) for start, end in zip(edges[::2], edges[1::2], strict=True)]
