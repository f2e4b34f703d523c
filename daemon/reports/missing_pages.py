"""The pages that a folder of logs lacks: of each run and each fault of every recording that was closed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

from config.errors import LongreachError
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
    """Make every page that is missing, newest log first; a log that gets none is told and left out. Standby recordings have no runs."""
    for log in sorted(recordings(folder), key=lambda path: path.stat().st_mtime_ns, reverse=True):
        if log.stem.endswith(STANDBY_ENDING) or not was_closed(log):
            continue
        try:
            yield from _missing(recorded(log), simulate, say)
        except LongreachError as error:
            say(f"no page of {log.name}: {error}")


def watch(folder: Path, simulate: bool, say: Say) -> Iterator[Path]:
    """The same for ever: logs that are closed from now on get their pages within seconds. A log that got none is not tried again."""
    told: set[str] = set()

    def once(line: str) -> None:
        if line not in told:
            told.add(line)
            say(line)

    seen: dict[Path, int] = {}
    while True:
        now = {log: log.stat().st_mtime_ns for log in recordings(folder)}
        if now != seen:
            yield from make_missing(folder, simulate, once)
            seen = now
        time.sleep(LOOK_S)


def _missing(log: Recorded, simulate: bool, say: Say) -> Iterator[Path]:
    for number in range(1, log.faults + 1):
        if not incident_page_of(log.path, number).exists():
            yield from (written.page for written in write_incidents(log.path, number))
    for run in log.runs:
        if not run_page_of(log.path, run.number).exists():
            yield from write_reports(log.path, [run.number], simulate, say)
