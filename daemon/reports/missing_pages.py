"""The pages that a folder of logs lacks: of each run and each fault of every recording that was closed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

from config.errors import LogError, LongreachError
from daemon.processes.recorder import STANDBY_ENDING
from daemon.reports.incident import incident_page_of
from daemon.reports.incident_page import write_incidents
from daemon.reports.run_report import run_page_of, write_reports
from recording.files.catalogue import Recorded, recorded
from recording.files.recordings import recordings
from recording.files.recover import was_closed

LOOK_S = 2.0

Say = Callable[[str], None]


def make_missing(folder: Path, simulate: bool, say: Say) -> Iterator[Path]:
    """Make every page that is missing, newest log first; a log that gets none is told and left out. Standby recordings have no runs.
    LogError for a folder that cannot be read."""
    for log, _ in _newest_first(folder):
        yield from _made(log, simulate, say)


def watch(folder: Path, simulate: bool, say: Say) -> Iterator[Path]:
    """The same for ever: logs that are closed from now on get their pages within seconds. Each is looked at once, and again when it
    changes."""
    done: dict[Path, int] = {}
    found = _newest_first(folder)
    while True:
        for log, changed_ns in found:
            if done.get(log) != changed_ns:
                yield from _made(log, simulate, say)
            done[log] = changed_ns
        time.sleep(LOOK_S)
        with suppress(LogError):  # moved away meanwhile, it may come back
            found = _newest_first(folder)


def _newest_first(folder: Path) -> list[tuple[Path, int]]:
    """Recordings that may have runs, with the time of their last change in ns; one may be removed meanwhile."""
    found = []
    for log in recordings(folder):
        with suppress(FileNotFoundError):
            if not log.stem.endswith(STANDBY_ENDING):
                found.append((log, log.stat().st_mtime_ns))
    return sorted(found, key=lambda each: each[1], reverse=True)


def _made(log: Path, simulate: bool, say: Say) -> Iterator[Path]:
    """None of a recording that goes on, or was moved away meanwhile."""
    try:
        if was_closed(log):
            yield from _missing(recorded(log), simulate, say)
    except (LongreachError, FileNotFoundError) as error:
        say(f"no page of {log.name}: {error}")


def _missing(log: Recorded, simulate: bool, say: Say) -> Iterator[Path]:
    for number in range(1, log.faults + 1):
        if not incident_page_of(log.path, number).exists():
            yield from (written.page for written in write_incidents(log.path, number))
    for run in log.runs:
        if not run_page_of(log.path, run.number).exists():
            yield from write_reports(log.path, [run.number], simulate, say)
