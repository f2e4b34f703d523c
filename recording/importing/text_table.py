"""Reads a text table (CSV) into numbers; every refusal names line and column."""

from __future__ import annotations

import csv
import math
import re
from array import array
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import TextIO

import numpy as np

from config.errors import LogError
from config.whole_file import system_advice
from recording.importing.date_times import seconds_of, since_first
from recording.importing.table import Floats, SourceTable

_DELIMITERS = (",", ";", "\t")
_WINDOWS = "cp1252"
_WITH_COMMA = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?")
Row = tuple[int, list[str]]


def read_text_table(path: Path) -> SourceTable:
    """A table with one line of column names, and perhaps one of their units below. Comma, semicolon or tab between cells; where it is no
    comma, numbers may have decimal commas. Lines that start with # are left out; dates become seconds since the first row.

    Raises LogError for an empty table, repeated names, rows of another length and cells that are no numbers.
    """
    encoding = _encoding(path)
    rows = _rows(path, encoding)
    first = next(rows, None)
    if first is None:
        raise LogError("the table is empty", where=str(path), next_step="It needs a line of column names and rows of numbers.")
    names, rows = _with_units(_named(first[1], path), rows)
    columns, lines, commas = [array("d") for _ in names], array("q"), 0
    dates: dict[str, list[bool]] = {}  # of every column of dates, whether its cells have a day
    for line, cells in rows:
        if len(cells) != len(names):
            advice = "Every row needs as many cells as there are column names."
            raise LogError("wrong number of cells", value=len(cells), limit=len(names), where=f"{path}:{line}", next_step=advice)
        lines.append(line)
        for column, name, cell in zip(columns, names, cells, strict=True):
            try:
                column.append(_plain(cell))
            except ValueError:
                moment = seconds_of(cell)
                if moment is not None:
                    column.append(moment[0])
                    dates.setdefault(name, []).append(moment[1])
                    continue
                column.append(_other_number(cell, name, path, line))
                commas += bool(cell)
    if not lines:
        raise LogError("the table has column names but no rows", where=str(path), next_step="There is nothing to import.")
    if commas:
        _refuse_other_signs(path, encoding)
    read = {name: np.frombuffer(column, dtype=np.float64) for name, column in zip(names, columns, strict=True)}
    read |= {name: _moments(read[name], days, f"{path}: column {name!r}") for name, days in dates.items()}
    notes = ("Numbers have decimal commas.",) * bool(commas) + (f"Read as {_WINDOWS}, not UTF-8.",) * (encoding == _WINDOWS)
    notes += tuple(f"Column {name!r} holds dates or times of day: read as seconds since its first row." for name in dates)
    return SourceTable(path, read, np.frombuffer(lines, dtype=np.int64), notes, frozenset(dates))


def _moments(seconds: Floats, days: list[bool], where: str) -> Floats:
    """A column of dates, or of times of day, as seconds since its first row; LogError where it mixes them with others."""
    if len(days) != np.isfinite(seconds).sum() or len(set(days)) > 1:
        advice = "Write all of its cells as dates with times, or all as times of day."
        raise LogError("dates, times of day and numbers stand in one column", where=where, next_step=advice)
    return since_first(seconds, days[0])


def _rows(path: Path, encoding: str) -> Iterator[Row]:
    """(line number, stripped cells) of every line that is neither blank nor a comment."""
    try:
        with path.open(encoding=encoding, newline="") as file:
            reader = csv.reader(file, delimiter=_delimiter(file))
            for cells in reader:
                if any(cell.strip() for cell in cells) and not cells[0].startswith("#"):
                    yield reader.line_num, [cell.strip() for cell in cells]
    except OSError as error:
        raise _unopened(path, error) from error
    except (UnicodeDecodeError, csv.Error) as error:
        advice = "Save it as a plain text table (CSV, UTF-8)."
        raise LogError("this is not a text table", value=str(error), where=str(path), next_step=advice) from error


def _delimiter(file: TextIO) -> str:
    """What stands most often in the first line; the file is back at its beginning."""
    head = next((line for line in file if line.strip() and not line.startswith("#")), "")
    file.seek(0)
    return max(_DELIMITERS, key=head.count)


def _encoding(path: Path) -> str:
    """UTF-8, with or without its mark, or what programs on Windows write in the West, where the bytes are no UTF-8. Bytes of 0 stand in no
    text: such a file is left to UTF-8, which refuses it."""
    try:
        content = path.read_bytes()
        content.decode("utf-8")
    except OSError as error:
        raise _unopened(path, error) from error
    except UnicodeDecodeError:
        return "utf-8-sig" if b"\0" in content else _WINDOWS
    return "utf-8-sig"


def _unopened(path: Path, error: OSError) -> LogError:
    reason = error.strerror or str(error)
    return LogError("the table cannot be opened", value=reason, where=str(path), next_step=system_advice(error))


def _named(names: list[str], path: Path) -> list[str]:
    """The names; a column without one, as a separator at the end of each line makes it, gets its number."""
    repeated = sorted({name for name in names if name and names.count(name) > 1})
    if repeated:
        raise LogError("column names stand twice", value=", ".join(repeated), where=str(path), next_step="Rename or remove one of each.")
    if all(_is_number(name) for name in names):
        advice = "The first line must be the column names, for example t_s,rotary.position,rotary.command_V."
        raise LogError("the table has no line of column names", value=",".join(names)[:60], where=str(path), next_step=advice)
    return [name or f"column {number}" for number, name in enumerate(names, 1)]


def _with_units(names: list[str], rows: Iterator[Row]) -> tuple[list[str], Iterator[Row]]:
    """Where the line below the names has as many words and no number, these are units: `pos` over `mm` is read as `pos [mm]`."""
    second = next(rows, None)
    if second is None:
        return names, iter(())
    units = second[1]
    if not 1 < len(names) == len(units) or any(_is_number(unit) or _WITH_COMMA.fullmatch(unit) for unit in units):
        return names, chain([second], rows)
    bare = [unit.strip("[]()") for unit in units]
    return [f"{name} [{unit}]" if unit else name for name, unit in zip(names, bare, strict=True)], rows


def _other_number(cell: str, name: str, path: Path, line: int) -> float:
    """An empty cell is NaN, `0,25` a quarter; LogError for anything else."""
    if not cell:
        return math.nan
    if _WITH_COMMA.fullmatch(cell):
        return float(cell.replace(",", "."))
    what = f"column {name!r} holds something that is no number"
    advice = "Write numbers without units; leave the cell empty where there is none."
    raise LogError(what, value=repr(cell), where=f"{path}:{line}", next_step=advice)


def _refuse_other_signs(path: Path, encoding: str) -> None:
    """Beside decimal commas a point might be anything; and where commas stand between cells, so might one in a quoted cell."""
    with path.open(encoding=encoding, newline="") as file:
        between_cells = _delimiter(file) == ","
    for line, cells in _rows(path, encoding):
        for cell in cells:
            if between_cells and _WITH_COMMA.fullmatch(cell):
                what = "a comma stands in a number, in a table with commas between cells"
                advice = "Write a point for decimals and nothing between thousands, or put semicolons between the cells."
                raise LogError(what, value=repr(cell), where=f"{path}:{line}", next_step=advice)
            if "." in cell and _is_number(cell):
                advice = "Write all numbers with one sign, and none between thousands."
                raise LogError("decimal points stand beside decimal commas", value=cell, where=f"{path}:{line}", next_step=advice)


def _plain(cell: str) -> float:
    """A number as other programs write it: float() alone would also take Python's 1_000."""
    if "_" in cell:
        raise ValueError(cell)
    return float(cell)


def _is_number(text: str) -> bool:
    try:
        _plain(text)
    except ValueError:
        return False
    return True
