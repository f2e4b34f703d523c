"""What the loop is commanded to do, and how a command reaches it without the loop ever waiting."""

from __future__ import annotations

import pickle
from collections import deque
from dataclasses import dataclass
from typing import Protocol

from config.errors import DaemonError
from daemon.ipc.ring import Ring
from daemon.modes.mode_machine import OperatorAction
from servo_control.streaming.any_plan import AnyPlan

NOT_SET_UP = "not_set_up"  # the event that says why a reset was refused by a device


@dataclass(frozen=True, slots=True)
class StartRun:
    """A run, planned and checked already, with the texts that go into the log."""

    plan: AnyPlan
    request_json: str
    maneuver_yaml: str
    countdown_s: float


@dataclass(frozen=True, slots=True)
class LoopCommand:
    """`leave`: controlled stop, disarm, and end the loop. `start` is a request for motion: it is announced first.

    `countdown_s`: announcement before the action PROVE. `new_recorder`: it was started again and knows of no recording.
    """

    action: OperatorAction = OperatorAction.NONE
    start: StartRun | None = None
    countdown_s: float = 0.0
    leave: bool = False
    new_recorder: bool = False


class CommandSource(Protocol):
    """Where the loop takes its commands from, at most one a cycle."""

    def poll(self) -> LoopCommand | None:
        """The next command or None, at once."""


class CommandQueue:
    """Commands from the same process, for lockstep and tests."""

    def __init__(self) -> None:
        self._waiting: deque[LoopCommand] = deque()

    def post(self, command: LoopCommand) -> None:
        self._waiting.append(command)

    def poll(self) -> LoopCommand | None:
        return self._waiting.popleft() if self._waiting else None


class CommandRing:
    """Commands from the supervisor. They are pickled: both ends are this program, and no other process has the memory."""

    def __init__(self, ring: Ring) -> None:
        self._ring = ring

    def post(self, command: LoopCommand) -> bool:
        """False when the loop has not fetched what came before. DaemonError for a run that is too long for it."""
        data = pickle.dumps(command, protocol=pickle.HIGHEST_PROTOCOL)
        if len(data) > self._ring.largest_bytes:
            value, limit = f"{len(data) / 1e6:.3g}", f"{self._ring.largest_bytes / 1e6:.3g}"
            advice = "Give a smaller `--repeat`, or a program with fewer moves, and start it again when it has ended."
            raise DaemonError("the planned run is too long for the loop", value=value, limit=limit, unit="MB", next_step=advice)
        return self._ring.write(0, 0, data)

    def poll(self) -> LoopCommand | None:
        record = self._ring.read()
        if record is None:
            return None
        command: LoopCommand = pickle.loads(record.data)
        return command
