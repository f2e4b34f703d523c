"""A ring of records between two processes: one writes, one reads, neither ever waits for the other. A full ring drops and counts.

Header, one 64-byte line for each side so that they do not share one: line 0 belongs to the writer (head, dropped), line 1 to the
reader (tail). Head and tail count bytes since the beginning and never wrap. A record is: length, kind (32 bit each), stamp in ns
(64 bit), data padded to 8 bytes; a record never wraps round the end, the rest of the memory is skipped instead.

The data is written before head is moved on and read before tail is. This is enough where stores become visible in order (x86);
a machine with weaker order needs a barrier before `head` and `tail` are stored.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from daemon.ipc.shared_memory import SharedMemory

_HEADER_BYTES = 128
_HEAD, _DROPPED, _TAIL = 0, 1, 8  # words
_RECORD = struct.Struct("<IIq")
_SKIP = 0xFFFFFFFF  # length of a record that only fills the end of the memory


def stored_bytes(length: int) -> int:
    """What a record with so many bytes of data takes: a header of 16, and padding to 8."""
    return 16 + length + -length % 8


class Record(NamedTuple):
    kind: int
    stamp_ns: int
    data: bytes


class Ring:
    """Either end of a ring, over memory both ends share."""

    def __init__(self, shared: SharedMemory) -> None:
        self.shared = shared
        self._words = shared.words
        self._bytes = shared.bytes
        self._capacity = len(shared.bytes) - _HEADER_BYTES
        self._free = 0  # bytes the writer knows to be free, so that it reads the reader's line only when it has to

    @classmethod
    def create(cls, name: str, capacity: int) -> Ring:
        """`capacity` in bytes, for records and their 16-byte headers."""
        return cls(SharedMemory.create(name, _HEADER_BYTES + capacity + -capacity % 8))

    def write(self, kind: int, stamp_ns: int, data: bytes | bytearray | memoryview) -> bool:
        """Append a record. False, and one more in `dropped`, when there is no room for it."""
        length = len(data)
        size = stored_bytes(length)
        head = self._words[_HEAD]
        at = head % self._capacity
        skip = self._capacity - at if at + size > self._capacity else 0
        if self._free < skip + size:
            self._free = self._capacity - (head - self._words[_TAIL])
            if self._free < skip + size:
                self._words[_DROPPED] += 1
                return False
        if skip >= 16:
            _RECORD.pack_into(self._bytes, _HEADER_BYTES + at, _SKIP, 0, 0)
        if skip:
            at = 0
        start = _HEADER_BYTES + at
        _RECORD.pack_into(self._bytes, start, length, kind, stamp_ns)
        self._bytes[start + 16 : start + 16 + length] = data
        self._free -= skip + size
        self._words[_HEAD] = head + skip + size
        return True

    def read(self) -> Record | None:
        """The oldest record, or None when there is none."""
        tail = self._words[_TAIL]
        if tail == self._words[_HEAD]:
            return None
        at = tail % self._capacity
        length, kind, stamp = _RECORD.unpack_from(self._bytes, _HEADER_BYTES + at) if self._capacity - at >= 16 else (_SKIP, 0, 0)
        if length == _SKIP:
            tail += self._capacity - at
            at = 0
            length, kind, stamp = _RECORD.unpack_from(self._bytes, _HEADER_BYTES)
        start = _HEADER_BYTES + at + 16
        data = bytes(self._bytes[start : start + length])
        self._words[_TAIL] = tail + stored_bytes(length)
        return Record(kind, stamp, data)

    @property
    def largest_bytes(self) -> int:
        """Of a record that finds room wherever the ring stands, once all before it were read: half, since none wraps round the end."""
        return self._capacity // 2 - 16

    @property
    def dropped(self) -> int:
        """Records that found no room since the ring was made."""
        return self._words[_DROPPED]

    @property
    def backlog_bytes(self) -> int:
        """What the reader has not read yet."""
        return self._words[_HEAD] - self._words[_TAIL]
