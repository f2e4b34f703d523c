"""The latest values of one process for the others: never waited on, never half written, each with the time it was put there.

Two slots; the writer fills the one not in use and then makes it valid by one store of the sequence number. A writer that is killed
half way leaves the values before; a reader that was overtaken tries again.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import NamedTuple

from daemon.ipc.shared_memory import SharedMemory

_SEQUENCE = 0
_FIRST_SLOT = 8  # bytes
_TRIES = 100  # a reader is overtaken only when it was preempted between two copies


class LatestValues(NamedTuple):
    """What a mailbox holds. `stamp_ns`: of the monotonic clock, when they were put there."""

    sequence: int  # number of puts so far
    stamp_ns: int
    values: tuple[float, ...]


class Mailbox:
    """Numbers of fixed count. One process puts, any number read."""

    def __init__(self, shared: SharedMemory) -> None:
        self.shared = shared
        slot_bytes = (len(shared.bytes) - _FIRST_SLOT) // 2
        self.length = slot_bytes // 8 - 1
        self._struct = struct.Struct(f"<q{self.length}d")
        self._slots = (_FIRST_SLOT, _FIRST_SLOT + slot_bytes)

    @classmethod
    def create(cls, name: str, length: int) -> Mailbox:
        return cls(SharedMemory.create(name, _FIRST_SLOT + 2 * 8 * (1 + length)))

    def put(self, stamp_ns: int, values: Sequence[float]) -> None:
        """struct.error when the number of values is not the mailbox's."""
        sequence = self.shared.words[_SEQUENCE] + 1
        self._struct.pack_into(self.shared.bytes, self._slots[sequence & 1], stamp_ns, *values)
        self.shared.words[_SEQUENCE] = sequence

    def get(self) -> LatestValues | None:
        """The latest values; None before the first put."""
        for _ in range(_TRIES):
            sequence = self.shared.words[_SEQUENCE]
            if sequence == 0:
                return None
            stamp, *values = self._struct.unpack_from(self.shared.bytes, self._slots[sequence & 1])
            if self.shared.words[_SEQUENCE] == sequence:
                return LatestValues(sequence, stamp, tuple(values))
        return None

    @property
    def sequence(self) -> int:
        return self.shared.words[_SEQUENCE]
