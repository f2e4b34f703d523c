"""Process data objects of a simulated device: which objects one frame carries, when it goes out, when a missing one is an error."""

from __future__ import annotations

import struct

from sim_backend.twin.can.dictionary import MAPPING, PDO_OFF, TPDO
from sim_backend.twin.can.object_store import Key, ObjectStore

_LONGEST_BITS = 64
_MOST_OBJECTS = 8
LAST_SYNCHRONOUS = 240
_LETTER_OF_BITS = {8: "Bb", 16: "Hh", 32: "Ii"}
NOT_MAPPABLE, TOO_LONG, PDO_IS_ON = 0x0604_0041, 0x0604_0042, 0x0601_0000


class Pdo:
    """One PDO as it is set up at present; `refresh` reads the set-up from the store again."""

    def __init__(self, store: ObjectStore, communication: int) -> None:
        self._store = store
        self.communication = communication
        self.mapping = communication + MAPPING
        self.is_transmit = communication >= TPDO
        self.cob_id = 0
        self.is_on = False
        self.every_syncs = 0  # 0: not synchronous
        self.event_timer_ns = 0
        self.keys: tuple[Key, ...] = ()
        self._layout = struct.Struct("<")
        self.refresh()

    def refresh(self) -> None:
        values = self._store.values
        cob_id = values[self.communication, 1]
        transmission = values[self.communication, 2]
        self.cob_id = cob_id & 0x7FF
        self.is_on = not cob_id & PDO_OFF
        self.every_syncs = transmission if 1 <= transmission <= LAST_SYNCHRONOUS else 0
        self.event_timer_ns = values[self.communication, 5] * 1_000_000
        entries = [values[self.mapping, sub] for sub in range(1, values[self.mapping, 0] + 1)]
        self.keys = tuple((entry >> 16, entry >> 8 & 0xFF) for entry in entries)
        self._layout = struct.Struct("<" + "".join(self._store.number_format(key) or "" for key in self.keys))

    def pack(self) -> bytes:
        """The frame's data from the present values."""
        values = self._store.values
        return self._layout.pack(*[values[key] for key in self.keys])

    def unpack(self, data: bytes) -> bool:
        """Store what a frame carries; False when it is too short, which changes nothing (CiA 301: PDO length error)."""
        if len(data) < self._layout.size:
            return False
        self._store.values.update(zip(self.keys, self._layout.unpack_from(data), strict=True))
        return True

    def refuses(self, subindex: int, value: int) -> int | None:
        """SDO abort code for a write to the mapping, or None. A mapping is changed while the PDO is off and its count is 0."""
        values = self._store.values
        if self.is_on:
            return PDO_IS_ON
        if subindex == 0:
            return self._refuses_count(value)
        if values[self.mapping, 0] != 0:
            return PDO_IS_ON
        letter = self._store.number_format((value >> 16, value >> 8 & 0xFF))
        return None if letter and letter in _LETTER_OF_BITS.get(value & 0xFF, "") else NOT_MAPPABLE

    def _refuses_count(self, count: int) -> int | None:
        if count > _MOST_OBJECTS:
            return TOO_LONG
        entries = [self._store.values[self.mapping, sub] for sub in range(1, count + 1)]
        if not all(entries):
            return NOT_MAPPABLE
        return None if sum(entry & 0xFF for entry in entries) <= _LONGEST_BITS else TOO_LONG
