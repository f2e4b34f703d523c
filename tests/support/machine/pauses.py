"""A test on the wall clock that fails while the machine itself stands still says nothing of the code: it gets another try.

If the machine stands still in every try the test is skipped, with the pauses seen and what it said, so that nobody takes it for passed.
Where no process may have real-time priority nothing is watched, and every failure counts.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import pytest
from _pytest.runner import runtestprotocol

TRIES = 3
# The time limit of a test counts over all of its tries.
LATEST_TRY_S = 100.0


class Pause(NamedTuple):
    begin_s: float
    end_s: float

    @property
    def length_ms(self) -> float:
        return (self.end_s - self.begin_s) * 1e3


class Pauses:
    """Plug-in of pytest."""

    def __init__(self) -> None:
        self.directory = Path(tempfile.mkdtemp(prefix="pauses-"))
        self.watchers: list[subprocess.Popen[bytes]] = []
        self.told: list[str] = []

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        if any(item.get_closest_marker("clock") for item in session.items) and not session.config.option.collectonly:
            self.watchers = [self.watcher(processor) for processor in sorted(os.sched_getaffinity(0))]

    def watcher(self, processor: int) -> subprocess.Popen[bytes]:
        command = [
            sys.executable,
            "-IS",
            str(Path(__file__).with_name("pause_watch.py")),
            str(processor),
            str(self.directory / f"{processor}.txt"),
        ]
        return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def pytest_unconfigure(self) -> None:
        for watcher in self.watchers:
            watcher.kill()
            watcher.wait(10)
        shutil.rmtree(self.directory, ignore_errors=True)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        if not self.watchers or item.get_closest_marker("clock") is None:
            return None
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        for report in self.tried(item, nextitem):
            item.ihook.pytest_runtest_logreport(report=report)
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        return True

    def tried(self, item: pytest.Item, nextitem: pytest.Item | None) -> list[pytest.TestReport]:
        """The reports of the try that counts."""
        begin = time.monotonic()
        for last in (*[False] * (TRIES - 1), True):
            start = time.monotonic()
            reports = runtestprotocol(item, nextitem=nextitem, log=False)
            failed = [report for report in reports if report.failed]
            pauses = self.seen(start) if failed else []
            if not pauses:
                return reports
            self.tell(item, pauses, failed[0])
            if last or time.monotonic() - begin > LATEST_TRY_S:
                return [not_judged(report, item, pauses) for report in reports]
            item.session._setupstate.teardown_exact(None)  # daemons that other tests share met the pause too
        raise AssertionError("the last try returns")

    def seen(self, start_s: float) -> list[Pause]:
        lines = (line for path in self.directory.glob("*.txt") for line in path.read_text().splitlines())
        pauses = (Pause(*map(float, line.split())) for line in lines)
        return [pause for pause in pauses if pause.end_s > start_s]

    def tell(self, item: pytest.Item, pauses: list[Pause], failed: pytest.TestReport) -> None:
        said = str(getattr(getattr(failed.longrepr, "reprcrash", None), "message", failed.longrepr)).splitlines()
        self.told.append(f"{item.nodeid}: {in_words(pauses)}; {said[0] if said else ''}")

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if not self.told:
            return
        terminalreporter.section("tries that failed while the machine stood still")
        for line in self.told:
            terminalreporter.line(line)


def in_words(pauses: list[Pause]) -> str:
    longest = max(pause.length_ms for pause in pauses)
    return f"the machine stood still {len(pauses)} times, the longest {longest:.0f} ms"


def not_judged(report: pytest.TestReport, item: pytest.Item, pauses: list[Pause]) -> pytest.TestReport:
    if report.failed:
        report.outcome = "skipped"
        report.longrepr = (str(item.path), item.location[1] or 0, f"Skipped: not judged, {in_words(pauses)}")
    return report
