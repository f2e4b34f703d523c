"""The daemon's desk over a loop in lockstep: what a client gets, without processes and sockets."""

from __future__ import annotations

import asyncio

from control.signals import Mode
from daemon.command import Command
from daemon.desk import Desk
from daemon.journal import Journal
from daemon.lockstep import LockstepRig
from daemon.status import StatusView
from daemon.timing import WORDS, Timing


class Office:
    """A desk whose loop moves on when the desk looks at it: by a cycle while something was asked for, else at every tenth look."""

    def __init__(self, rig: LockstepRig) -> None:
        self.rig = rig
        self.shutdowns = self._posted = self._looks = 0
        self.journal = Journal()
        view = StatusView(rig.rig, rig.facts, Timing([0] * WORDS))
        self.desk = Desk(rig.rig, rig.facts, self.journal, view, self._values, self._post, self._nothing_to_repair, self._shut_down)

    def _values(self) -> tuple[float, ...]:
        self._looks += 1
        asked = self.rig.value("commands") < self._posted or self.rig.mode in (Mode.ARMING, Mode.PROVING)
        if asked or self._looks % 10 == 0:
            self.rig.cycles(1)
        for event in self.rig.events:
            self.journal.add(event)
        self.rig.events.clear()
        return tuple(self.rig.loop.values)

    def _post(self, command: Command) -> int:
        self.rig.commands.post(command)
        self._posted += 1
        return self._posted

    async def _nothing_to_repair(self) -> None:
        return

    def _shut_down(self) -> None:
        self.shutdowns += 1


_give_way = asyncio.sleep


async def at_once(seconds: float) -> None:
    """In place of asyncio.sleep: the loop moves on when it is looked at, not with time."""
    await _give_way(0)
