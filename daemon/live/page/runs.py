"""The newest runs among the daemon's logs, with validity and the vibration they left, and the report of each."""

from __future__ import annotations

import secrets
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import LogError, LongreachError
from daemon.live.page.background import Background
from daemon.live.page.guard import RequestError
from daemon.live.source.connection import ask_once

if TYPE_CHECKING:
    from recording.files.catalogue import Recorded
    from recording.files.info import RunFacts

LIST_LIMIT_S = 120.0
REPORT_LIMIT_S = 300.0
RUNS_SHOWN = 100
LOGS_READ = 60  # the newest
LARGEST_OPEN_BYTES = 400_000_000  # of a log that has no index yet and must be read whole
TICKET_S = 600.0  # how long the address of a report leads to it
REPORTS_KEPT = 20


class Runs:
    """Of the folder where the daemon at `socket` writes its logs."""

    def __init__(self, socket: str) -> None:
        self._socket = socket
        self._listing, self._reporting = Background("listing runs", LIST_LIMIT_S), Background("making a report", REPORT_LIMIT_S)
        self._reports: dict[str, tuple[float, str]] = {}  # ticket → until when, page

    async def newest(self) -> dict[str, Any]:
        """`runs`, newest first."""
        status = await self._status()
        return await self._listing.run(newest_runs, str(Path(status["log"]["path"]).parent), status["rig"])

    async def report(self, log: object, run: object) -> dict[str, Any]:
        """`page`: where the report of a run can be opened for a while. A browser sends no token with an address, so it is in there."""
        folder = Path((await self._status())["log"]["path"]).parent
        if not isinstance(log, str) or Path(log).name != log or not log.endswith(".mcap") or not isinstance(run, int):
            raise RequestError(400, "a report needs log (a name) and run (a number)")
        made = await self._reporting.run(report_page, str(folder / log), run)
        now, ticket = time.monotonic(), secrets.token_urlsafe(24)
        kept = [(name, kept) for name, kept in self._reports.items() if kept[0] > now]
        self._reports = {**dict(kept[-REPORTS_KEPT + 1 :]), ticket: (now + TICKET_S, made["page"])}
        return {"page": f"/report/{ticket}"}

    def page_of(self, ticket: str) -> str:
        """RequestError for a ticket that is none, or no longer."""
        until, page = self._reports.get(ticket, (0.0, ""))
        if time.monotonic() > until:
            raise RequestError(404, "no such report", "Open it again from the page.")
        return page

    def close(self) -> None:
        self._listing.close()
        self._reporting.close()

    async def _status(self) -> dict[str, Any]:
        status = await ask_once(self._socket, "status", {}, 5.0)
        if not status["log"]["path"]:
            raise LogError("the daemon has written no log yet", next_step="Runs appear here once the arm was armed.")
        return status


def newest_runs(folder: str, rig_name: str) -> dict[str, Any]:
    """Of the newest logs in a folder. A log that cannot be used is left out; `longreach runs` says why."""
    from recording.evaluation.kept_vibration import residual_vibration

    ours = [log for log in _newest_logs(Path(folder)) if log.rig_name == rig_name]
    left = residual_vibration([log.path for log in ours if log.complete])
    runs = [_shown(log, run, left.get(log.path, {}).get(run.number)) for log in ours for run in log.runs]
    runs.sort(key=lambda run: float(str(run["started_unix_s"])), reverse=True)
    return {"runs": runs[:RUNS_SHOWN]}


def _newest_logs(folder: Path) -> Iterator[Recorded]:
    from recording.files.catalogue import logs_in, recorded

    logs = sorted((path for path in logs_in([folder]) if not path.stem.endswith("-standby")), key=lambda path: path.stat().st_mtime)
    for path in logs[-LOGS_READ:]:
        if path.stat().st_size <= LARGEST_OPEN_BYTES:
            with suppress(LongreachError):
                yield recorded(path)


def _shown(log: Recorded, run: RunFacts, vibration_mps2: float | None) -> dict[str, Any]:
    return {
        "log": log.path.name,
        "run": run.number,
        "maneuver": run.maneuver,
        "shaper": run.shaper,
        "started_unix_s": log.begun[run.number].timestamp(),
        "duration_s": run.duration_s,
        "valid": run.valid,
        "reason": run.reason,
        "vibration_mps2": vibration_mps2,
    }


def report_page(log: str, run: int) -> dict[str, Any]:
    """The report that stands beside the log, or else a new one, without the simulated run, which takes longer than somebody waits."""
    path = Path(log)
    beside = path.with_name(f"{path.stem}-run-{run}.html")
    if beside.is_file():
        return {"page": beside.read_text(encoding="utf-8")}
    from daemon.reports.run_report import run_page
    from recording.files.reader import read_log

    return {"page": run_page(read_log(path), run, simulate=False)}
