"""What is counted on a CAN bus since it was opened: the names in logs and in `longreach status`, which are those of the attributes."""

from __future__ import annotations

from enum import IntEnum
from typing import Any


class BusState(IntEnum):
    """Of our own controller, as its error frames say (SocketCAN; other interfaces say nothing and count as ACTIVE)."""

    ACTIVE = 0
    WARNING = 1
    PASSIVE = 2
    OFF = 3


BUS_COUNTS = (
    "frames",  # for one of our devices
    "foreign",  # for none of them
    "left_over",  # cycles in which more frames came than one cycle takes
    "send_failures",
    "error_frames",
    "state",  # BusState
)
DEVICE_COUNTS = (
    "received",  # frames of its process data
    "late",  # of them, used after the cycle in which they were due
    "lost",  # that were due and never came
    "stale",  # cycles that had values older than 2 ms, times the SYNCs between two frames
    "malformed",
    "emergency",  # code of the last EMCY, 0 for none
    "nmt_state",
)


def counts_of(counted: Any, names: tuple[str, ...]) -> dict[str, float]:
    return {name: float(getattr(counted, name)) for name in names}
