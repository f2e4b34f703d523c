"""Asks the daemon in turn for samples, status, checks and events, as long as somebody watches, and hands them to every view.

However many views a process has, the daemon is asked once. A daemon that ends is waited for; the views hear of both.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from typing import Any

from config.errors import LongreachError
from daemon.live.source.connection import Connection
from daemon.live.source.pending import EVENTS_KEPT, Content, Pending
from daemon.live.source.scene import scene
from daemon.server.stated_values import Units, as_stated, units_from

SAMPLE_HZ = 50.0
STATUS_HZ = 5.0
CHECKS_HZ = 2.0
AGAIN_S = 0.5  # until a daemon that does not answer is asked again
ANSWER_LIMIT_S = 5.0
_BEFORE_ALL_S = -1e9


class Feed:
    """What it hands out, by key: `rig` (see `scene`), `samples` (rows: unix_s, then the rig's signals in SI), `status`,
    `checks` (in the units of the rig file), `events`, and `lost`: why the daemon does not answer, empty when it does."""

    def __init__(self, socket: str | PathLike[str], sample_Hz: float = SAMPLE_HZ) -> None:
        self._connection = Connection(socket)
        self._period_s = 1.0 / sample_Hz
        self._watching: set[Pending] = set()
        self._somebody = asyncio.Event()
        self._known: Content = {}  # the newest of everything but samples and events
        self._events: list[dict[str, Any]] = []
        self._since_t_s = _BEFORE_ALL_S
        self._due: dict[str, float] = {}

    @contextmanager
    def watched(self) -> Iterator[Pending]:
        """A view's share; what is known already is in it."""
        pending = Pending()
        pending.put({**self._known, "events": self._events})
        self._watching.add(pending)
        self._somebody.set()
        try:
            yield pending
        finally:
            self._watching.discard(pending)
            if not self._watching:
                self._somebody.clear()

    async def run(self) -> None:
        """Until it is cancelled."""
        while True:
            await self._somebody.wait()
            try:
                await self._follow()
            except LongreachError as error:
                self._hand_out({"lost": str(error)})
                await asyncio.sleep(AGAIN_S)
            finally:
                self._connection.close()

    async def _follow(self) -> None:
        """From the first answer of a daemon to its last. Raises DaemonError when it no longer answers."""
        self._hand_out({"rig": scene(await self._ask("rig")), "lost": ""})
        units = units_from(await self._ask("units"))
        self._events, self._since_t_s, self._due = [], _BEFORE_ALL_S, {}
        next_s = time.monotonic()
        while self._somebody.is_set():
            await self._samples()
            await self._rest(units)
            next_s = max(next_s + self._period_s, time.monotonic())
            await asyncio.sleep(next_s - time.monotonic())

    async def _samples(self) -> None:
        answer = await self._ask("sample", since_t_s=self._since_t_s)
        rows = answer["rows"]
        if rows:
            self._since_t_s = rows[-1][self._known["rig"]["at_t_s"]]
            self._hand_out({"samples": [[answer["unix_s"], *row] for row in rows]})

    async def _rest(self, units: Units) -> None:
        if self._is_due("status", STATUS_HZ):
            self._hand_out({"status": await self._ask("status")})
            since = self._events[-1]["n"] if self._events else 0
            new = (await self._ask("events", since=since))["events"]
            if new:
                self._events = [*self._events, *new][-EVENTS_KEPT:]
                self._hand_out({"events": new})
        if self._is_due("checks", CHECKS_HZ):
            self._hand_out({"checks": [as_stated(check, units) for check in (await self._ask("checks"))["checks"]]})

    def _is_due(self, what: str, rate_Hz: float) -> bool:
        now = time.monotonic()
        if now < self._due.get(what, 0.0):
            return False
        self._due[what] = now + 1.0 / rate_Hz
        return True

    async def _ask(self, method: str, **params: Any) -> dict[str, Any]:
        return await self._connection.call(method, params, ANSWER_LIMIT_S)

    def _hand_out(self, content: Content) -> None:
        self._known.update({key: value for key, value in content.items() if key not in ("samples", "events")})
        for pending in self._watching:
            pending.put(content)
