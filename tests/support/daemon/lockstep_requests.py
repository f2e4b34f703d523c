"""The daemon's request handlers over a loop in lockstep: what a client gets, without processes and sockets."""

from __future__ import annotations

import asyncio

from daemon.cycle.timing import WORDS, Timing
from daemon.lockstep import LockstepRig
from daemon.loop.command import LoopCommand
from daemon.server.event_history import EventHistory
from daemon.server.request_handlers import RequestHandlers
from daemon.server.status import StatusView
from servo_control.signals import Mode, SetPoint


class LockstepRequests:
    """A loop that moves on when its values are read: by a cycle while something was asked for, else at every tenth reading."""

    def __init__(self, rig: LockstepRig, rig_text: str = "") -> None:
        self.rig = rig
        self.shutdowns = self._posted = self._readings = 0
        self.stands_still_s = 0.0
        self.history = EventHistory()
        self.facts, self.view = rig.facts, StatusView(rig.rig, rig.facts, Timing([0] * WORDS))
        self.handlers = RequestHandlers(rig.rig, self, rig_text)

    def values(self) -> tuple[float, ...]:
        self._readings += 1
        asked = self.rig.value("commands") < self._posted or self.rig.mode in (Mode.ARMING, Mode.PROVING)
        if asked or self._readings % 10 == 0:
            self.rig.cycles(1)
        for event in self.rig.events:
            self.history.add(event)
        self.rig.events.clear()
        return tuple(self.rig.loop.values)

    def silent_s(self) -> float:
        return self.stands_still_s

    def post(self, command: LoopCommand) -> int:
        self.rig.commands.post(command)
        self._posted += 1
        return self._posted

    def post_set_point(self, point: SetPoint) -> None:
        self.rig.set_points.post(point)

    async def repair(self) -> bool:
        return False

    def shut_down(self) -> None:
        self.shutdowns += 1


_give_way = asyncio.sleep


async def at_once(seconds: float) -> None:
    """In place of asyncio.sleep: the loop moves on when its values are read, not with time."""
    await _give_way(0)
