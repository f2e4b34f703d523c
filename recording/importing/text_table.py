"""Reads a text table (CSV) into numbers; every refusal names line and column."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from config.errors import LogError
from config.whole_file import system_advice
from recording.importing.table import SourceTable

_DELIMITERS = (",", ";", "\t")


def read_text_table(path: Path) -> SourceTable:
    """A table with one line of column names. Comma, semicolon or tab between cells; lines that start with # are left out.

    Raises LogError for an empty table, repeated names, rows of another length and cells that are no numbers.
    """
    rows = _rows(path)
    try:
        _, names = next(rows)
    except StopIteration:
        raise LogError("the table is empty", where=str(path), next_step="It needs a line of column names and rows of numbers.") from None
    _check_names(names, path)
    lines, numbers = [], []
    for line, cells in rows:
        if len(cells) != len(names):
            advice = "Every row needs as many cells as there are column names."
            raise LogError("wrong number of cells", value=len(cells), limit=len(names), where=f"{path}:{line}", next_step=advice)
        lines.append(line)
        numbers.append([_number(cell, name, path, line) for cell, name in zip(cells, names, strict=True)])
    if not lines:
        raise LogError("the table has column names but no rows", where=str(path), next_step="There is nothing to import.")
    table = np.array(numbers, dtype=np.float64)
    return SourceTable(path, {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(names)}, np.array(lines, dtype=np.int64))


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """(line number, stripped cells) of every line that is neither blank nor a comment."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            head = next((line for line in file if line.strip() and not line.startswith("#")), "")
            file.seek(0)
            reader = csv.reader(file, delimiter=max(_DELIMITERS, key=head.count))
            for cells in reader:
                if any(cell.strip() for cell in cells) and not cells[0].startswith("#"):
                    yield reader.line_num, [cell.strip() for cell in cells]
    except OSError as error:
        reason = error.strerror or str(error)
        raise LogError("the table cannot be opened", value=reason, where=str(path), next_step=system_advice(error)) from error
    except (UnicodeDecodeError, csv.Error) as error:
        advice = "Save it as a plain text table (CSV, UTF-8)."
        raise LogError("this is not a text table", value=str(error), where=str(path), next_step=advice) from error


def _check_names(names: list[str], path: Path) -> None:
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise LogError("column names stand twice", value=", ".join(repeated), where=str(path), next_step="Rename or remove one of each.")
    if all(_is_number(name) for name in names):
        advice = "The first line must be the column names, for example t_s,rotary.position,rotary.command_V."
        raise LogError("the table has no line of column names", value=",".join(names)[:60], where=str(path), next_step=advice)


def _number(cell: str, name: str, path: Path, line: int) -> float:
    if not cell:
        return math.nan
    try:
        number = float(cell)
    except ValueError:
        what = f"column {name!r} holds something that is no number"
        advice = "Write numbers with a decimal point and without units; leave the cell empty where there is none."
        raise LogError(what, value=repr(cell), where=f"{path}:{line}", next_step=advice) from None
    if math.isinf(number):
        raise LogError(f"column {name!r} is infinite", value=cell, where=f"{path}:{line}", next_step="Correct or empty the cell.")
    return number


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
