"""How the set points of whoever drives by hand reach the loop: the newest one, once, without the loop ever waiting.

A set point that is overtaken by the next one before the loop looks is lost, and so none is ever late because others wait before it.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol

from daemon.ipc.mailbox import Mailbox
from servo_control.signals import SetPoint

if TYPE_CHECKING:
    from config.schema.rig import Rig

_HEAD = 4  # run, what is wanted, how late, how many values


class SetPointSource(Protocol):
    """Where the loop takes its set points from."""

    def take(self) -> SetPoint | None:
        """The newest set point since the last call, None without one; at once."""


class NewestSetPoint:
    """Set points from the same process, for lockstep and tests."""

    def __init__(self) -> None:
        self._newest: SetPoint | None = None

    def post(self, point: SetPoint) -> None:
        self._newest = point

    def take(self) -> SetPoint | None:
        point, self._newest = self._newest, None
        return point


class SetPointBox:
    """Set points through a mailbox: the supervisor posts, the loop takes."""

    def __init__(self, box: Mailbox) -> None:
        self._box = box
        self._taken = box.sequence

    def post(self, point: SetPoint) -> None:
        room = self._box.length - _HEAD
        values = [*point.values, *[0.0] * (room - len(point.values))]
        self._box.put(time.monotonic_ns(), [float(point.run), float(point.wanted), point.late_s, float(len(point.values)), *values])

    def take(self) -> SetPoint | None:
        if self._box.sequence == self._taken:
            return None
        latest = self._box.get()
        if latest is None:
            return None
        self._taken = latest.sequence
        run, wanted, late_s, count, *values = latest.values
        return SetPoint(int(run), int(wanted), tuple(values[: int(count)]), late_s)


def set_point_mailbox(rig: Rig) -> Mailbox:
    """With room for a value of every joint, or for x and y."""
    return Mailbox.create("set_points", _HEAD + max(2, len(rig.joints)))
