"""Events: mode changes, commands, interlocks, faults, overruns, drops. Stored as CDR on the topic /event.

The layout is plain ROS 2 (strings and sequences), so its bytes cannot come from one struct as those of a cycle do.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from enum import IntEnum

from config.errors import LogError

EVENT_SCHEMA = "longreach_msgs/msg/Event"
EVENT_SCHEMA_TEXT = """\
uint64 cycle  # executed cycle in which it happened
float64 t_s  # [s] deadline of that cycle since the loop started
uint8 level  # 20 information, 30 warning, 40 error, 50 fault (numbers of rcl_interfaces/Log)
string name  # short stable name, for programs
string text  # one sentence with values and units, for people
string[] value_names  # names with unit suffix of the numbers below
float64[] values  # numbers that belong to the text
"""
_HEADER = b"\x00\x01\x00\x00"


class Level(IntEnum):
    """How serious an event is; the numbers are those of rcl_interfaces/Log so that viewers colour them."""

    INFO = 20
    WARNING = 30
    ERROR = 40
    FAULT = 50


@dataclass(frozen=True, slots=True)
class Event:
    """One event. `values` maps names with unit suffix to numbers."""

    cycle: int
    t_s: float
    level: int
    name: str
    text: str
    values: dict[str, float] = field(default_factory=dict)


def encode_event(event: Event) -> bytes:
    """CDR bytes of an event. Raises LogError when a number does not fit its field."""
    try:
        body = bytearray(struct.pack("<QdB", event.cycle, event.t_s, event.level))
    except struct.error as error:
        raise LogError("an event cannot be stored", value=repr((event.cycle, event.t_s, event.level)), next_step=str(error)) from error
    _put_string(body, event.name)
    _put_string(body, event.text)
    _put_count(body, len(event.values))
    for name in event.values:
        _put_string(body, name)
    _put_count(body, len(event.values))
    if event.values:
        body += bytes(-len(body) % 8)
        body += struct.pack(f"<{len(event.values)}d", *event.values.values())
    return _HEADER + bytes(body)


def decode_event(data: bytes) -> Event:
    """The event in these CDR bytes. Raises LogError when they are not a whole event."""
    try:
        cycle, t_s, level = struct.unpack_from("<QdB", data, 4)
        name, at = _get_string(data, 4 + 17)
        text, at = _get_string(data, at)
        count, at = _get_count(data, at)
        names = []
        for _ in range(count):
            value_name, at = _get_string(data, at)
            names.append(value_name)
        count, at = _get_count(data, at)
        values = struct.unpack_from(f"<{count}d", data, 4 + _aligned(at - 4, 8)) if count else ()
        return Event(cycle, t_s, level, name, text, dict(zip(names, values, strict=True)))
    except (struct.error, ValueError, MemoryError, OverflowError) as error:
        raise LogError("an event of the log cannot be read", value=f"{len(data)} bytes", next_step=str(error)) from error


def _put_count(body: bytearray, count: int) -> None:
    body += bytes(-len(body) % 4)
    body += struct.pack("<I", count)


def _put_string(body: bytearray, text: str) -> None:
    encoded = text.encode("utf-8", "replace") + b"\x00"
    _put_count(body, len(encoded))
    body += encoded


def _aligned(position: int, size: int) -> int:
    return position + (-position % size)


def _get_count(data: bytes, at: int) -> tuple[int, int]:
    at = 4 + _aligned(at - 4, 4)
    return struct.unpack_from("<I", data, at)[0], at + 4


def _get_string(data: bytes, at: int) -> tuple[str, int]:
    length, at = _get_count(data, at)
    if length == 0 or at + length > len(data):
        raise ValueError("a text is longer than the message")
    return data[at : at + length - 1].decode("utf-8"), at + length
