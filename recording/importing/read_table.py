"""The table in a file, whatever its format."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from config.errors import LogError
from recording.importing.table import Floats, SourceTable
from recording.importing.text_table import read_text_table


def read_table(path: str | Path) -> SourceTable:
    """MATLAB's by its ending, else text. LogError for what is no table, and for numbers that are infinite."""
    table = _read(Path(path))
    for name, values in table.columns.items():
        _refuse_infinite(table, name, values)
    return table


def _read(path: Path) -> SourceTable:
    if path.suffix.lower() != ".mat":
        return read_text_table(path)
    from recording.importing.mat_table import read_mat  # scipy, only where it is needed

    return read_mat(path)


def _refuse_infinite(table: SourceTable, name: str, values: Floats) -> None:
    rows = np.flatnonzero(np.isinf(values))
    if len(rows):
        where, advice = f"{table.path}:{table.lines[rows[0]]}", "Correct it, or leave it empty (NaN)."
        raise LogError(f"column {name!r} is infinite", value=values[rows[0]], where=where, next_step=advice)
