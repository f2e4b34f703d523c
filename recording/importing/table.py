"""A table that was read: named columns of numbers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SourceTable:
    """Columns of floats by name; an empty cell is NaN. `lines` holds each row's line in the file, `notes` how it was read where that is
    not as usual, `dates` the columns that hold dates or times of day, in seconds since their first row."""

    path: Path
    columns: dict[str, Floats]
    lines: npt.NDArray[np.int64]
    notes: tuple[str, ...] = ()
    dates: frozenset[str] = frozenset()

    @property
    def rows(self) -> int:
        return len(self.lines)
