"""What a run that has just ended left behind, from its log: the recording of an armed rig goes on, and is read as far as it is.

The run's page is made by a process of its own at the lowest priority, while the arm holds still.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import LogError
from recording.files.reader import Log, read_log

if TYPE_CHECKING:
    from tuning.shaper_choice.shaped_moves import ShapedMove

LONGEST_WAIT_S = 5.0  # for the recorder to write the run's last rows
_LOWEST = 19  # priority of making a page
LARGEST_BYTES = 400_000_000  # reading more would keep the operator waiting; `longreach log info` has no limit


def moves_of_run(started: dict[str, Any], result: dict[str, Any]) -> list[ShapedMove]:
    """Predicted and measured vibration of a run, from the daemon's answers to `start` and `wait`; empty when it was not valid, not
    shaped or its log cannot be read from here."""
    from tuning.shaper_choice.shaped_moves import shaped_moves  # scipy takes a while to load

    if result["validity"] != "valid" or started.get("shaper") == "none":
        return []
    log = _log_with_end(_paths(started, result), int(result["run"]))
    return [] if log is None else shaped_moves(log, [int(result["run"])])


def report_of_run(started: dict[str, Any], result: dict[str, Any]) -> list[str]:
    """The pages made of a run that has ended, and of the fault that ended it; empty, with the reason on stderr, where its log cannot be
    read or written beside."""
    number = int(result["run"])
    log = _log_with_end(_paths(started, result), number)
    if log is None:
        print("no report: the log of the run cannot be read from here; `longreach log report` makes one where it can", file=sys.stderr)
        return []
    pages = _pages("report", str(log.path), "--run", str(number))
    faults = 0 if result["validity"] == "valid" else sum(event.name == "fault" for event in read_log(log.path).events)
    return pages + (_pages("incident", str(log.path), "--fault", str(faults)) if faults else [])


def _pages(*words: str) -> list[str]:
    command = [sys.executable, "-m", "daemon.cli.main", "log", *words, "--json"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False, preexec_fn=lambda: os.nice(_LOWEST))
    return list(json.loads(done.stdout)["pages"]) if done.returncode == 0 else []


def _paths(started: dict[str, Any], result: dict[str, Any]) -> tuple[Path, ...]:
    """A long recording is cut between runs."""
    return tuple(dict.fromkeys(Path(str(answer.get("log", ""))) for answer in (started, result)))


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
