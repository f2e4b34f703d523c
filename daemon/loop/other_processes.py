"""The other processes as the loop knows them: who sends commands, and who reports and reads health. Nothing here ever waits."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from daemon.loop.command import CommandSource
from daemon.loop.set_points import NewestSetPoint, SetPointSource


class ProcessHealth(Protocol):
    """What the loop hears of recorder and supervisor, and what they hear of it; called once a cycle."""

    def update(self, values: list[float], now_ns: int) -> None:
        """Put the facts about recorder, disk and supervisor into `values`."""

    def publish(self, values: list[float], now_ns: int, urgent: bool) -> None:
        """Show the facts of this cycle; `urgent` after a change somebody waits for."""


@dataclass(frozen=True, slots=True)
class OtherProcesses:
    """Both directions to the supervisor and the recorder."""

    commands: CommandSource
    health: ProcessHealth
    set_points: SetPointSource = field(default_factory=NewestSetPoint)
