"""The last valid run of the same maneuver on the same rig before a given one, in the same log or beside it."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from config.errors import LogError
from recording.files.catalogue import Recorded, recorded
from recording.files.reader import Log
from recording.files.recordings import recordings

MOST_LOGS = 500  # looked at, newest first: some 10 ms each


def last_valid_run(log: Log, run: int, maneuver: str) -> tuple[Path, int] | None:
    """Log and number of the run, None when there is none."""
    row = int(np.flatnonzero(log.columns["maneuver"] == run)[0])
    before = datetime.fromtimestamp(int(log.time_ns[row]) * 1e-9, UTC)
    rig_name = log.metadata.get("recording", {}).get("rig_name", "")
    newest_first = sorted(recordings(log.path.parent), key=lambda path: path.stat().st_mtime_ns, reverse=True)
    best: tuple[datetime, str, int, Path] | None = None
    for path in newest_first[:MOST_LOGS]:
        found = _last(path, rig_name, maneuver, before, (log.path.name, run))
        if found and (best is None or found > best):
            best = found
    return (best[3], best[2]) if best else None


def _last(path: Path, rig_name: str, maneuver: str, before: datetime, but: tuple[str, int]) -> tuple[datetime, str, int, Path] | None:
    try:
        log: Recorded = recorded(path)
    except LogError:
        return None
    if log.rig_name != rig_name:
        return None
    found = [
        (log.begun[run.number], path.name, run.number, path)
        for run in log.runs
        if run.valid and run.maneuver == maneuver and log.begun[run.number] < before and (path.name, run.number) != but
    ]
    return max(found, default=None)
