"""Which rows of a table become a log: the spans of time that were asked for, cut where nothing was measured for long.

The search for the gap cuts the logs it is given with the same `between_pauses`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from config.errors import LogError
from recording.importing.table import Floats

SPLIT_S = 1.0  # a gap longer than this ends a log and begins another: nobody knows what the machine did meanwhile
LEAST_ROWS = 2
Span = tuple[float, float]
Columns = Mapping[str, Floats]


def parts(columns: dict[str, Floats], spans: Sequence[Span], where: str) -> tuple[list[dict[str, Floats]], tuple[str, ...]]:
    """The columns of each log, in the order of time, and a sentence about rows that are in none. `spans`: in s of t_s, none for all of it.
    LogError when nothing is left."""
    t = columns["t_s"]
    chosen = [rows(columns, (t >= first) & (t <= last)) for first, last in spans] or [columns]
    found = [piece for one in chosen for piece in between_pauses(one, LEAST_ROWS)]
    if not found and not spans:
        what = f"no {LEAST_ROWS} rows follow each other without a pause"
        raise LogError(what, value=f"{len(t)} in all", where=where, next_step="There is nothing to import.")
    if not found:
        asked = ", ".join(f"{first:g} to {last:g} s" for first, last in spans)
        raise LogError(
            "no rows in this span of time",
            value=asked,
            limit=f"{t[0]:.6g} to {t[-1]:.6g} s",
            where=where,
            next_step="Give --from and --to in seconds of the log's t_s.",
        )
    return found, _alone([piece for one in chosen for piece in between_pauses(one, 1) if len(piece["t_s"]) < LEAST_ROWS])


def _alone(pieces: Sequence[Columns]) -> tuple[str, ...]:
    """One row makes no log."""
    if not pieces:
        return ()
    count, first_s = sum(len(piece["t_s"]) for piece in pieces), pieces[0]["t_s"][0]
    rows_are = "1 row is" if count == 1 else f"{count} rows are"
    return (f"{rows_are} left out, alone between pauses of more than {SPLIT_S:g} s: the first at t_s = {first_s:.6g} s.",)


def between_pauses(columns: Columns, least_rows: int) -> list[dict[str, Floats]]:
    """The pieces between steps of `t_s` longer than SPLIT_S, in the order of the rows, without those of fewer than `least_rows` rows."""
    t = columns["t_s"]
    edges = [0, *(np.flatnonzero(np.diff(t) > SPLIT_S) + 1).tolist(), len(t)]
    return [rows(columns, slice(first, last)) for first, last in pairwise(edges) if last - first >= least_rows]


def rows(columns: Columns, chosen: slice | NDArray[np.bool_]) -> dict[str, Floats]:
    return {name: values[chosen] for name, values in columns.items()}
