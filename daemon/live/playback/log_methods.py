"""The daemon's requests that look, answered from a log that is being played."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from typing import Any

from config.errors import DaemonError
from daemon.checks.interlocks import interlocks
from daemon.checks.past_checks import checks_at
from daemon.cycle.timing import QUANTITIES, WORDS, Timing
from daemon.live.playback.log_player import LogPlayer
from daemon.server.event_history import EventHistory, RunResult
from daemon.server.live_values import LiveValues, since_t_s, units_answer
from daemon.server.request_handlers import METHODS
from daemon.server.status import StatusView

ROWS_AT_ONCE = 1000
ROW_S = 0.02  # of the log; rows between are left out
TIMED_ROWS = 500  # of one answer: their lateness makes the percentiles
CHECKS_EVERY_S = 2.0  # asking the checks of a moment takes a tenth of a second and more


class LogMethods:
    """`methods`: as those of the daemon's request handlers."""

    def __init__(self, player: LogPlayer) -> None:
        self._player, self._log = player, player.log
        self._text = player.log.attachments["rig.yaml"].decode()
        self._live = LiveValues(player.rig, player.facts)
        self._timing = Timing([0] * WORDS)
        self._view = StatusView(player.rig, player.facts, self._timing)
        self._history = EventHistory()
        self._events_done = self._timed = 0
        self._checks: list[dict[str, Any]] = []
        self._checks_due = 0.0
        looks = {name: getattr(self, name) for name in ("status", "checks", "units", "rig", "sample", "maneuvers", "events")}
        self.methods: dict[str, Callable[[dict[str, Any]], Awaitable[dict[str, Any]]]] = {**dict.fromkeys(METHODS, _refuse), **looks}

    async def rig(self, params: dict[str, Any]) -> dict[str, Any]:
        return {"name": self._player.rig.name, "text": self._text, "signals": self._live.signals, "played": self._log.path.name}

    async def sample(self, params: dict[str, Any]) -> dict[str, Any]:
        """Every row since `since_t_s`, no denser than ROW_S and no more than ROWS_AT_ONCE."""
        end, times = self._player.row_now(), self._log.columns["t_s"]
        since = max(since_t_s(params), float(times[end]) - ROWS_AT_ONCE * ROW_S)
        steps = range(ROWS_AT_ONCE if times[end] > since else 0)
        rows = {self._player.row_at(float(times[end]) - step * ROW_S) for step in steps if times[end] - step * ROW_S > since}
        newer = [row for row in sorted(rows) if times[row] > since]
        return {"unix_s": time.time(), "rows": [self._live.row(self._player.values(row)) for row in newer]}

    async def status(self, params: dict[str, Any]) -> dict[str, Any]:
        row = self._player.row_now()
        self._catch_up(row)
        values = self._player.values(row)
        answer = self._view.status(values, float(self._log.columns["t_s"][row]), self._history)
        return {**answer, "clock": "log", "estop": "unknown", "log": {"path": str(self._log.path), "bytes": self._log.path.stat().st_size}}

    async def checks(self, params: dict[str, Any]) -> dict[str, Any]:
        """Those of a moment at most CHECKS_EVERY_S ago; `ok` is None for what no log can tell."""
        if time.monotonic() >= self._checks_due:
            t_s = float(self._log.columns["t_s"][self._player.row_now()])
            self._checks = (await asyncio.to_thread(checks_at, self._log, t_s)).checks
            self._checks_due = time.monotonic() + CHECKS_EVERY_S
        return {"checks": self._checks}

    async def units(self, params: dict[str, Any]) -> dict[str, Any]:
        return units_answer(self._player.rig, interlocks(self._player.rig, self._player.facts), self._text)

    async def maneuvers(self, params: dict[str, Any]) -> dict[str, Any]:
        return {"maneuvers": []}

    async def events(self, params: dict[str, Any]) -> dict[str, Any]:
        self._catch_up(self._player.row_now())
        events = self._history.since(int(params.get("since", 0)))
        return {"events": events, "last": events[-1]["n"] if events else params.get("since", 0)}

    def _catch_up(self, row: int) -> None:
        """Runs, events and lateness up to this row."""
        t_s = float(self._log.columns["t_s"][row])
        for number, run in self._player.runs.items():
            if number not in self._history.runs and run.start_t_s <= t_s:
                self._history.begin_run(RunResult(number, run.maneuver, run.shaper, []))
        while self._events_done < len(self._log.events) and self._log.events[self._events_done].t_s <= t_s:
            self._history.add(self._log.events[self._events_done])
            self._events_done += 1
        for each in range(self._timed, row, max(1, (row - self._timed) // TIMED_ROWS)):
            self._count_times(each)
        self._timed = max(self._timed, row)

    def _count_times(self, row: int) -> None:
        for quantity, name in enumerate(QUANTITIES[:-1]):
            value = float(self._log.columns[f"{name}_us"][row])
            if value == value:  # data of another system have no times
                self._timing.count(quantity, value)


async def _refuse(params: dict[str, Any]) -> dict[str, Any]:
    raise DaemonError("a log is played: it can be looked at, not driven", next_step="Connect to the daemon's socket to drive.")
