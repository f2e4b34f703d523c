"""What a measured table must be to become a log: time that increases, no holes in positions and commands."""

from __future__ import annotations

import numpy as np

from config.errors import LogError
from recording.source_columns import Floats
from recording.table import Table

_NEEDED = ("position", "command_V")  # of at least one joint; and without holes where the table has them
_UNEVEN = 0.01  # of the median period


def refuse_unusable(table: Table, columns: dict[str, Floats], joints: tuple[str, ...]) -> None:
    """LogError with the table's line for the first thing that makes the data unusable."""
    if "t_s" not in columns:
        advice = "A column t_s (seconds) is needed; a map can name another column for it."
        raise LogError("the table has no time", where=str(table.path), next_step=advice)
    needed = [f"{joint}.{name}" for joint in joints for name in _NEEDED if f"{joint}.{name}" in columns]
    if not needed:
        advice = "At least one joint needs a position or a command, e.g. axis.position."
        raise LogError("the table has no position and no command", where=str(table.path), next_step=advice)
    for name in ("t_s", *needed):
        _refuse_holes(table, columns[name], name)
    _refuse_disorder(table, columns["t_s"])
    _refuse_fractions(table, columns)


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


def _refuse_holes(table: Table, values: Floats, name: str) -> None:
    rows = np.flatnonzero(np.isnan(values))
    if not len(rows):
        return
    what = f"{name} is missing (empty or NaN) in {len(rows)} of {table.rows} rows"
    advice = "Fill the gap, or cut the table into parts before and after it."
    raise LogError(what, where=f"{table.path}:{table.lines[rows[0]]}", next_step=advice)


def _refuse_disorder(table: Table, t: Floats) -> None:
    rows = np.flatnonzero(~(np.diff(t) > 0))
    if not len(rows):
        return
    row = int(rows[0]) + 1
    seen = f"{t[row - 1]!s} s, then {t[row]!s} s"
    advice = "Rows must be in the order of time, each once; sort them, or cut the table where the clock was set back."
    raise LogError("time does not increase", value=seen, where=f"{table.path}:{table.lines[row]}", next_step=advice)


def _refuse_fractions(table: Table, columns: dict[str, Floats]) -> None:
    """`mode`, `segment` and the other counters are whole numbers in a log."""
    for name in ("cycle", "mode", "maneuver", "segment", "overruns", "drops"):
        values = columns.get(name)
        if values is None:
            continue
        high = 255 if name == "mode" else 2**32 - 1
        bad = np.flatnonzero(~((values >= 0) & (values <= high) & (values == np.floor(values))))
        if len(bad):
            where = f"{table.path}:{table.lines[bad[0]]}"
            advice = "Correct it, or leave the column out."
            raise LogError(f"{name} is no whole number", value=values[bad[0]], limit=f"0 to {high}", where=where, next_step=advice)
