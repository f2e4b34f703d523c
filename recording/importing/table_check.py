"""What a measured table must be to become a log: time that increases, no holes in positions and commands."""

from __future__ import annotations

import shlex

import numpy as np
import numpy.typing as npt

from config.errors import LogError
from recording.importing.table import Floats, SourceTable

_NEEDED = ("position", "command_V")  # of at least one joint; and without holes where the table has them
MOST_EMPTY = 0.5  # of the rows
_UNEVEN = 0.01  # of the median period


def usable(table: SourceTable, columns: dict[str, Floats], joints: tuple[str, ...]) -> tuple[dict[str, Floats], tuple[str, ...]]:
    """The columns without rows in which time, a position or a command is empty, and a sentence for each that was. LogError with the
    table's line for the first thing that makes the data unusable."""
    if "t_s" not in columns:
        propose = f"`longreach import {shlex.quote(str(table.path))} --suggest` proposes one"
        advice = f"A column t_s (seconds) is needed; a map can name another column for it; {propose}."
        raise LogError("the table has no time", where=str(table.path), next_step=advice)
    needed = [f"{joint}.{name}" for joint in joints for name in _NEEDED if f"{joint}.{name}" in columns]
    if not needed:
        advice = "At least one joint needs a position or a command, e.g. axis.position."
        raise LogError("the table has no position and no command", where=str(table.path), next_step=advice)
    empty = {name: np.isnan(columns[name]) for name in ("t_s", *needed)}
    for name, holes in empty.items():
        _refuse_holes(table, holes, name)
    whole = ~np.any(list(empty.values()), axis=0)
    kept = {name: values[whole] for name, values in columns.items()}
    _refuse_disorder(table, kept["t_s"], table.lines[whole])
    _refuse_fractions(table, kept, table.lines[whole])
    return kept, tuple(f"{name} is empty in {holes.sum()} rows, which are left out." for name, holes in empty.items() if holes.any())


def warnings_about(columns: dict[str, Floats]) -> list[str]:
    """Sentences about what a user should know though the data can be used."""
    counts = {name: int(np.sum(np.isnan(values))) for name, values in columns.items()}
    sparse = [f"{name} is empty in {count} rows and stays NaN there." for name, count in counts.items() if count]
    steps = np.diff(columns["t_s"])
    if len(steps) and np.max(np.abs(steps - np.median(steps))) > _UNEVEN * np.median(steps):
        low, high = np.min(steps) * 1e3, np.max(steps) * 1e3
        sparse.append(f"The rows are not evenly spaced: {low:.4g} to {high:.4g} ms. A command is taken to hold until the next row.")
    return sparse


def rate_Hz(t: Floats) -> float:
    """Rows per second from the median period; NaN for a single row."""
    return float(1.0 / np.median(np.diff(t))) if len(t) > 1 else float("nan")


def _refuse_holes(table: SourceTable, holes: npt.NDArray[np.bool_], name: str) -> None:
    """Single empty cells cost their rows; a column that is mostly empty is no measurement."""
    rows = np.flatnonzero(holes)
    if len(rows) <= MOST_EMPTY * table.rows:
        return
    what = f"{name} is missing (empty or NaN) in {len(rows)} of {table.rows} rows"
    advice = "Choose another column for it in the map, or a part of the table that has it (--from S --to S)."
    raise LogError(what, where=f"{table.path}:{table.lines[rows[0]]}", next_step=advice)


def _refuse_disorder(table: SourceTable, t: Floats, lines: npt.NDArray[np.int64]) -> None:
    rows = np.flatnonzero(~(np.diff(t) > 0))
    if not len(rows):
        return
    row, twice = int(rows[0]) + 1, int(np.sum(np.diff(t) == 0))
    seen, mend = f"{t[row - 1]!s} s, then {t[row]!s} s", _part_before(t, row)
    advice = "Rows must be in the order of time, each once; sort them, or cut the table where the clock was set back"
    if t[row] == t[row - 1]:
        advice = f"{twice} rows have the stamp of the row before, and no regular period is certain of which all stamps are the rounding"
        advice += " (one gap or double row hides it). Remove double rows, export finer stamps, or take the part before or behind it"
    where, advice = f"{table.path}:{lines[row]}", f"{advice} (--from, --to)."
    raise LogError("time does not increase", value=seen, where=where, next_step=advice, mend=mend)


def _part_before(t: Floats, row: int) -> dict[str, str | None]:
    """The option that takes the rows before the disorder alone; empty where they are too few, or where later rows are of that time too."""
    before = t[:row] if t[row] != t[row - 1] else t[: row - 1]
    if len(before) < 2 or np.sum(t <= before[-1]) > len(before):
        return {}
    return {"--to": repr(float(before[-1]))}


def _refuse_fractions(table: SourceTable, columns: dict[str, Floats], lines: npt.NDArray[np.int64]) -> None:
    """`mode`, `segment` and the other counters are whole numbers in a log."""
    for name in ("cycle", "mode", "maneuver", "segment", "overruns", "drops"):
        values = columns.get(name)
        if values is None:
            continue
        high = 255 if name == "mode" else 2**32 - 1
        bad = np.flatnonzero(~((values >= 0) & (values <= high) & (values == np.floor(values))))
        if len(bad):
            where = f"{table.path}:{lines[bad[0]]}"
            advice = "Correct it, or leave the column out."
            raise LogError(f"{name} is no whole number", value=values[bad[0]], limit=f"0 to {high}", where=where, next_step=advice)
