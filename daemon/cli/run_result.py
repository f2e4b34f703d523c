"""What a run that has just ended left behind, from its log: the recording of an armed rig goes on, and is read as far as it is."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import LogError
from recording.reader import Log, read_log

if TYPE_CHECKING:
    from tuning.shaped_moves import ShapedMove

LONGEST_WAIT_S = 5.0  # for the recorder to write the run's last rows
LARGEST_BYTES = 400_000_000  # reading more would keep the operator waiting; `longreach log info` has no limit


def moves_of_run(result: dict[str, Any]) -> list[ShapedMove]:
    """Predicted and measured vibration of the run in the daemon's `wait` answer; empty when it was not valid, not shaped or its log
    cannot be read from here."""
    from tuning.shaped_moves import shaped_moves  # scipy takes a while to load

    log = _log_with_end(Path(str(result.get("log", ""))), int(result["run"])) if result["validity"] == "valid" else None
    return [] if log is None else shaped_moves(log, [int(result["run"])])


def _log_with_end(path: Path, run: int) -> Log | None:
    limit = time.monotonic() + LONGEST_WAIT_S
    while path.is_file() and path.stat().st_size <= LARGEST_BYTES and time.monotonic() < limit:
        try:
            log = read_log(path)
        except LogError:
            return None
        if any(event.name == "run_ended" and event.values.get("run") == run for event in log.events):
            return log
        time.sleep(0.2)
    return None
