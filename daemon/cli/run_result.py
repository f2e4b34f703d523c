"""What a run that has just ended left behind, from its log: the recording of an armed rig goes on, and is read as far as it is."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import LogError
from recording.reader import Log, read_log

if TYPE_CHECKING:
    from tuning.shaped_moves import ShapedMove

LONGEST_WAIT_S = 5.0  # for the recorder to write the run's last rows
LARGEST_BYTES = 400_000_000  # reading more would keep the operator waiting; `longreach log info` has no limit


def moves_of_run(started: dict[str, Any], result: dict[str, Any]) -> list[ShapedMove]:
    """Predicted and measured vibration of a run, from the daemon's answers to `start` and `wait`; empty when it was not valid, not
    shaped or its log cannot be read from here."""
    from tuning.shaped_moves import shaped_moves  # scipy takes a while to load

    if result["validity"] != "valid" or started.get("shaper") == "none":
        return []
    paths = tuple(dict.fromkeys(Path(str(answer.get("log", ""))) for answer in (started, result)))  # a long recording is cut between runs
    log = _log_with_end(paths, int(result["run"]))
    return [] if log is None else shaped_moves(log, [int(result["run"])])


def _log_with_end(paths: Sequence[Path], run: int) -> Log | None:
    limit = time.monotonic() + LONGEST_WAIT_S
    readable = [path for path in paths if path.is_file() and path.stat().st_size <= LARGEST_BYTES]
    while readable and time.monotonic() < limit:
        for path in readable:
            try:
                log = read_log(path)
            except LogError:
                return None
            if any(event.name == "run_ended" and event.values.get("run") == run for event in log.events):
                return log
        time.sleep(0.2)
    return None
