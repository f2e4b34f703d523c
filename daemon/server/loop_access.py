"""The loop as requests reach it: its latest facts, what stands against a request, and commands that are waited for."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from typing import Protocol

from config.errors import DaemonError
from daemon.checks.checks import Check
from daemon.cycle.facts import Facts
from daemon.loop.command import LoopCommand
from daemon.server.event_history import EventHistory
from daemon.server.loop_silence import ADVICE, sentence
from daemon.server.status import StatusView
from servo_control.signals import Mode, SetPoint

ANSWER_LIMIT_S = 5.0  # a healthy loop answers within milliseconds; arming takes a quarter of a second


class SupervisedLoop(Protocol):
    """The loop as the supervisor reaches it."""

    facts: Facts
    history: EventHistory
    view: StatusView

    def values(self) -> tuple[float, ...]:
        """Its latest facts."""

    def silent_s(self) -> float:
        """For how long it has stood still; 0 while it moves on."""

    def post(self, command: LoopCommand) -> int:
        """Hand it a command: its number since the start, 0 when the loop cannot take it."""

    def post_set_point(self, point: SetPoint) -> None:
        """Hand it a set point of a run that is driven by hand; the newest counts."""

    async def repair(self) -> bool:
        """Before a reset: start anew what has died beside the loop. Whether the recorder was."""

    def shut_down(self) -> None: ...


class LoopAccess:
    """Questions and commands of requests to the loop."""

    def __init__(self, loop: SupervisedLoop) -> None:
        self._loop = loop
        self.values, self.silent_s = loop.values, loop.silent_s

    def mode(self) -> Mode:
        return self._loop.view.mode(self.values())

    def refuse_failed(self, what: str, checks: Sequence[Check]) -> None:
        """DaemonError with every check that does not pass."""
        values = self.values()
        failed = [check for check in checks if not check.passes(values)]
        if failed:
            sentences = " ".join(check.sentence(values) for check in failed)
            names = ", ".join(check.name for check in failed)
            raise DaemonError(f"{what}: {len(failed)} of {len(checks)} checks fail", value=names, next_step=sentences)

    async def send(
        self, command: LoopCommand, done: Callable[[], bool], limit_s: float = ANSWER_LIMIT_S, posted: Callable[[], None] = lambda: None
    ) -> None:
        """Hand the loop a command, which is then `posted()`, and wait until it has carried it out and `done()`. DaemonError when it does
        not in time, or cannot take it."""
        index = self._loop.facts.index("commands")
        number = self._loop.post(command)
        if not number:
            raise DaemonError("the loop does not fetch its commands", next_step="See `systemctl status longreachd`.")
        posted()
        limit = time.monotonic() + limit_s
        while not (self.values()[index] >= number and done()):
            if time.monotonic() > limit:
                raise self._not_done(limit_s)
            await asyncio.sleep(0.005)

    def _not_done(self, limit_s: float) -> DaemonError:
        mode, silent_s = f"mode {self.mode().name.lower()}", self.silent_s()
        if silent_s:
            return DaemonError(sentence(silent_s), value=f"{mode} when it last moved", next_step=ADVICE)
        advice = "`longreach why` says what stands in the way."
        return DaemonError(f"the loop did not do it within {limit_s:g} s", value=mode, next_step=advice)
