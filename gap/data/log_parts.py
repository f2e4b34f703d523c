"""Logs as they are given: a whole file or a part of it (`steps.csv@3.2:8.5`), each cut where nothing was logged for long."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from config.errors import LogError
from config.schema.rig import Rig
from gap.data.measured import Columns, Measured, columns_of, on_grid
from gap.data.uniform_grid import LEAST_ROWS, MOST_MISSING
from recording.importing.parts import SPLIT_S, between_pauses, rows

_PART = re.compile(r"^(?P<file>.+)@(?P<first>[^@:/]*):(?P<last>[^@:/]*)$")


def load_parts(given: Sequence[Path | str], rig: Rig) -> list[Measured]:
    """Every log with steady sampling that these files hold. LogError for what cannot be used at all."""
    return [part for one in given for part in _parts(str(one), rig)]


def _parts(given: str, rig: Rig) -> list[Measured]:
    path, first_s, last_s = _asked(given)
    columns, rig_name = columns_of(path, rig)
    t = columns.get("t_s", np.empty(0))
    sha256 = hashlib.sha256(path.read_bytes()).hexdigest()
    a_part = bool(np.isfinite(first_s) or np.isfinite(last_s))
    wanted = rows(columns, (t >= first_s) & (t <= last_s)) if a_part else columns
    pieces = _split(wanted)
    if not pieces and t.size:
        raise LogError(
            "no part of the log is long enough",
            value=f"{len(wanted['t_s'])} rows of {t.size}",
            limit=f"{LEAST_ROWS} rows without a gap of {SPLIT_S:g} s",
            where=given,
            next_step=f"The log runs from {np.nanmin(t):.6g} to {np.nanmax(t):.6g} s. "
            + (f"Give another part: {path}@FROM:TO" if a_part else "Log longer, without a pause."),
        )
    return [on_grid(path, piece, rig, sha256, rig_name) for piece in pieces or [wanted]]


def _asked(given: str) -> tuple[Path, float, float]:
    """File and span in s; infinite where the part is open."""
    found = _PART.match(given)
    if found is None or Path(given).exists():
        return Path(given), -np.inf, np.inf
    try:
        ends = [float(found[name]) if found[name] else infinite for name, infinite in (("first", -np.inf), ("last", np.inf))]
    except ValueError:
        advice = "Write FILE@FROM:TO in seconds of the log's t_s, e.g. steps.csv@3.2:8.5 (either end may be empty)."
        raise LogError("the part of the log is no span of time", where=given, next_step=advice) from None
    return Path(found["file"]), ends[0], ends[1]


def _split(columns: Columns) -> Sequence[Columns]:
    """Pieces between long gaps, without those too short to sample, where gaps are most of the log; else it stays one, and only the windows
    in its gaps are left out. Time that runs backwards is on_grid's matter."""
    t = columns.get("t_s", np.empty(0))
    steps = np.diff(t)
    lost_s = float(steps[steps > SPLIT_S].sum())
    if not lost_s > MOST_MISSING * (t[-1] - t[0] if t.size else 0.0):
        return [columns] if t.size >= LEAST_ROWS else []
    return between_pauses(columns, LEAST_ROWS)
