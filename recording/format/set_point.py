"""Set points of a run that is driven by hand: what reached the loop in which cycle. Stored as CDR on the topic /set_point.

Only logs of such runs have the topic. With it the run re-executes bit for bit: a set point is an input of its cycle.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from config.errors import LogError
from servo_control.signals import SetPoint

SET_POINT_SCHEMA = "longreach_msgs/msg/SetPoint"
SET_POINT_SCHEMA_TEXT = """\
uint64 cycle  # executed cycle whose controller step got it
float64 t_s  # [s] deadline of that cycle since the loop started
uint32 run  # number of the run
uint8 wanted  # 1 rates, 2 target positions, 3 velocity of the tip, 4 end of the run, 5 the client has hung up
float64 late_s  # [s] how much longer it was on its way than the quickest one; 0 where the client sends no time
float64[] values  # of every joint in its order, rad or m, per s; 3: x and y in m/s
"""
_HEADER = b"\x00\x01\x00\x00"
_HEAD = struct.Struct("<4sQdIB3xdI")  # up to the number of values


class StampedSetPoint(NamedTuple):
    """A set point and the cycle that got it."""

    cycle: int
    t_s: float
    point: SetPoint


def encode_set_point(stamped: StampedSetPoint) -> bytes:
    """CDR bytes."""
    cycle, t_s, (run, wanted, values, late_s) = stamped
    head = _HEAD.pack(_HEADER, cycle, t_s, run, wanted, late_s, len(values))
    return head + struct.pack(f"<4x{len(values)}d", *values) if values else head


def decode_set_point(data: bytes) -> StampedSetPoint:
    """The inverse. Raises LogError for bytes that are no whole set point."""
    try:
        _, cycle, t_s, run, wanted, late_s, count = _HEAD.unpack_from(data)
        values = struct.unpack_from(f"<{count}d", data, _HEAD.size + 4) if count else ()
    except (struct.error, MemoryError, OverflowError) as error:
        raise LogError("a set point of the log cannot be read", value=f"{len(data)} bytes", next_step=str(error)) from error
    return StampedSetPoint(cycle, t_s, SetPoint(run, wanted, values, late_s))
