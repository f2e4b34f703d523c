"""Least, greatest, mean and standard deviation of values that come one by one (Welford, Technometrics 4, 1962)."""

from __future__ import annotations

from math import inf, nan, sqrt


class Statistics:
    """Of the values taken so far; `sd` of a sample, NaN below two values."""

    def __init__(self) -> None:
        self.count = 0
        self.least, self.greatest, self.mean = inf, -inf, nan
        self._squares = 0.0

    def take(self, value: float) -> None:
        self.count += 1
        before = self.mean if self.count > 1 else 0.0
        self.mean = before + (value - before) / self.count
        self._squares += (value - before) * (value - self.mean)
        self.least, self.greatest = min(self.least, value), max(self.greatest, value)

    @property
    def sd(self) -> float:
        return sqrt(self._squares / (self.count - 1)) if self.count > 1 else nan
