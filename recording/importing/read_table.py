"""The table in a file, whatever its format."""

from __future__ import annotations

from pathlib import Path

from recording.importing.table import SourceTable
from recording.importing.text_table import read_text_table


def read_table(path: str | Path) -> SourceTable:
    """MATLAB's by its ending, else text. LogError for what is no table."""
    path = Path(path)
    if path.suffix.lower() != ".mat":
        return read_text_table(path)
    from recording.importing.mat_table import read_mat  # scipy, only where it is needed

    return read_mat(path)
