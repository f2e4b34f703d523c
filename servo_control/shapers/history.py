"""Ring of the last samples of several signals, addressed by sample number; before the first sample everything was at rest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


class History:
    """`columns[c][n & mask]` is signal c at sample n. Samples before 0 count as sample 0 with rate signals at rest."""

    __slots__ = ("columns", "count", "mask")

    def __init__(self, signals: int, length: int) -> None:
        size = 1 << max(3, (length + 2).bit_length())
        self.mask = size - 1
        self.columns = [[0.0] * size for _ in range(signals)]
        self.count = 0

    def reset(self, start: Sequence[float]) -> None:
        """Every sample so far was `start` (rates are given as 0 by the caller)."""
        for column, value in zip(self.columns, start, strict=True):
            column[:] = [value] * len(column)
        self.count = 0

    def append(self, values: Sequence[float]) -> None:
        place = self.count & self.mask
        for column, value in zip(self.columns, values, strict=True):
            column[place] = value
        self.count += 1

    def delayed(self, column: list[float], samples: float) -> float:
        """The signal `samples` (not negative, need not be whole) before the newest one, by linear interpolation."""
        whole = int(samples)
        fraction = samples - whole
        newest = self.count - 1
        late = column[(newest - whole) & self.mask]
        return late + fraction * (column[(newest - whole - 1) & self.mask] - late)

    def snapshot(self) -> dict[str, Any]:
        return {"count": self.count, "columns": [list(column) for column in self.columns]}

    def restore(self, state: dict[str, Any]) -> None:
        self.count = int(state["count"])
        for column, saved in zip(self.columns, state["columns"], strict=True):
            column[:] = saved
