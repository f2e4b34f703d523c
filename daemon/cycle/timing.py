"""How well the loop kept time: histograms of lateness and of every phase, their maxima, and a grade for the configured rate."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from typing import Protocol

EDGES_US = (
    0.5, 1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, 150, 200, 300, 500, 700, 1000, 1500, 2000, 3000, 5000, 7000, 10_000, 20_000,
    50_000, 100_000, 1_000_000,
)  # fmt: skip
QUANTITIES = ("late", "read", "compute", "write", "work")  # `work`: everything but the wait
_BINS = len(EDGES_US) + 1
WORDS = len(QUANTITIES) * (_BINS + 1)  # counts, and one maximum in ns each


class Words(Protocol):
    """Whole numbers by index: a list, or a view of shared memory."""

    def __getitem__(self, index: int, /) -> int: ...

    def __setitem__(self, index: int, value: int, /) -> None: ...


class Timing:
    """Counts in `words`, which may be shared memory that another process reads while the loop counts."""

    def __init__(self, words: Words) -> None:
        self._words = words

    def clear(self) -> None:
        for number in range(WORDS):
            self._words[number] = 0

    def count(self, quantity: int, length_us: float) -> None:
        """One value of QUANTITIES[quantity]."""
        words = self._words
        base = quantity * (_BINS + 1)
        words[base + 1 + bisect_left(EDGES_US, length_us)] += 1
        length_ns = int(length_us * 1e3)
        if length_ns > words[base]:
            words[base] = length_ns

    def largest_us(self, quantity: str) -> float:
        return self._words[self._base(quantity)] * 1e-3

    def counts(self, quantity: str) -> list[int]:
        base = self._base(quantity) + 1
        return [int(self._words[number]) for number in range(base, base + _BINS)]

    def percentile_us(self, quantity: str, percent: float) -> float:
        """Upper edge of the bin that holds the percentile, or the maximum where that is less; 0 without values."""
        counts = self.counts(quantity)
        wanted, seen = percent / 100.0 * sum(counts), 0
        for edge, count in zip((*EDGES_US, float("inf")), counts, strict=True):
            seen += count
            if count and seen >= wanted:
                return min(edge, self.largest_us(quantity))
        return 0.0

    def _base(self, quantity: str) -> int:
        return QUANTITIES.index(quantity) * (_BINS + 1)


def grade(late_p99_us: float, overruns: int, cycles: int, period_us: float) -> str:
    """A: late p99 ≤ 5 % of the period and ≤ 1 overrun in 10 000 cycles; B: ≤ 20 % and ≤ 1 in 1000; C: anything worse."""
    late, share = late_p99_us / period_us, overruns / max(1, cycles)
    if late <= 0.05 and share <= 1e-4:
        return "A"
    return "B" if late <= 0.2 and share <= 1e-3 else "C"


def passport(timing: Timing, overruns: dict[str, int], missed_periods: int, cycles: int, rate_Hz: float) -> dict[str, str]:
    """The evidence of one recording, as strings for the log's closing metadata. `overruns`: number by culprit phase."""
    total = sum(overruns.values())
    entries = {
        "rate_Hz": f"{rate_Hz:g}",
        "overruns": str(total),
        "missed_periods": str(missed_periods),
        "overrun_culprits": ", ".join(f"{phase} {count}" for phase, count in overruns.items() if count) or "none",
        "grade": grade(timing.percentile_us("late", 99.0), total, cycles, 1e6 / rate_Hz),
        "histogram_edges_us": _numbers(EDGES_US),
    }
    for quantity in QUANTITIES:
        entries[f"{quantity}_us_p50"] = f"{timing.percentile_us(quantity, 50.0):.4g}"
        entries[f"{quantity}_us_p99"] = f"{timing.percentile_us(quantity, 99.0):.4g}"
        entries[f"{quantity}_us_max"] = f"{timing.largest_us(quantity):.4g}"
        entries[f"{quantity}_histogram"] = _numbers(timing.counts(quantity))
    return entries


def _numbers(values: Sequence[float]) -> str:
    return " ".join(f"{value:g}" for value in values)
