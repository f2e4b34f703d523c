"""The values of a simulated device, and SDO access to them: one store of numbers for settings and process data, checked on writing.

canopen's SdoServer speaks the protocol; it asks this store for bytes. The store is also what PDOs read and write, by key.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from canopen import SdoAbortedError
from canopen.objectdictionary import ODArray, ODVariable
from canopen.sdo import SdoServer

from sim_backend.twin.can.dictionary import NUMBER

Key = tuple[int, int]
Send = Callable[[int, bytes], None]
Guard = Callable[[int, int, int], int | None]  # (index, sub-index, value) → SDO abort code, or None when the write is allowed

NO_OBJECT, NO_SUBINDEX = 0x0602_0000, 0x0609_0011
READ_ONLY, WRITE_ONLY = 0x0601_0002, 0x0601_0001
WRONG_LENGTH, GENERAL_ERROR = 0x0607_0010, 0x0800_0000
LAST_SUBINDEX = 0xFE
_FEWEST_REQUEST_BYTES = 8
_LONGEST_DOWNLOAD = 64  # bytes; no object is longer


class ObjectStore:
    """Every entry of a dictionary with its present value. `values` holds the numbers, and they are all a CANopen device here has."""

    def __init__(self, objects: Any, guard: Guard, written: Callable[[int, int], None]) -> None:
        self.object_dictionary = objects
        self._guard = guard
        self._written = written
        self.values: dict[Key, int] = {}
        self.restore_defaults()

    def restore_defaults(self) -> None:
        """What the device does when it is reset: nothing that was written is kept."""
        self.values.clear()
        for item in self.object_dictionary.values():
            for entry in [item] if isinstance(item, ODVariable) else item.values():
                self.values[entry.index, entry.subindex] = entry.default or 0

    def number_format(self, key: Key) -> str | None:
        """Struct letter of a number entry; None when there is no such entry."""
        try:
            return NUMBER.get(self._entry(*key).data_type)
        except SdoAbortedError:
            return None

    def get_data(self, index: int, subindex: int, check_readable: bool = False) -> bytes:
        """For SdoServer. Raises SdoAbortedError."""
        entry = self._entry(index, subindex)
        if check_readable and not entry.readable:
            raise SdoAbortedError(WRITE_ONLY)
        return struct.pack(f"<{NUMBER[entry.data_type]}", self.values[index, subindex])

    def set_data(self, index: int, subindex: int, data: bytes, check_writable: bool = False) -> None:
        """For SdoServer. Raises SdoAbortedError."""
        entry = self._entry(index, subindex)
        letter = NUMBER[entry.data_type]
        if check_writable and not entry.writable:
            raise SdoAbortedError(READ_ONLY)
        if len(data) != struct.calcsize(f"<{letter}"):
            raise SdoAbortedError(WRONG_LENGTH)
        (value,) = struct.unpack(f"<{letter}", bytes(data))
        refusal = self._guard(index, subindex, value)
        if refusal is not None:
            raise SdoAbortedError(refusal)
        self.values[index, subindex] = value
        self._written(index, subindex)

    def _entry(self, index: int, subindex: int) -> Any:
        item = self.object_dictionary.get(index)
        if item is None:
            raise SdoAbortedError(NO_OBJECT)
        if isinstance(item, ODVariable):
            if subindex != 0:
                raise SdoAbortedError(NO_SUBINDEX)
            return item
        if isinstance(item, ODArray) and subindex > (item[0].default or LAST_SUBINDEX):
            raise SdoAbortedError(NO_SUBINDEX)  # canopen would invent further elements
        try:
            entry = item[subindex]
        except KeyError:
            raise SdoAbortedError(NO_SUBINDEX) from None
        self.values.setdefault((index, subindex), entry.default or 0)
        return entry


class SdoPort:
    """The SDO server of a node. A request canopen's server cannot digest is answered with an abort instead of an exception."""

    def __init__(self, node_id: int, store: ObjectStore, send: Send) -> None:
        self.request_cob_id = 0x600 + node_id
        self._answer_cob_id = 0x580 + node_id
        self._send = send
        self._server = SdoServer(self.request_cob_id, self._answer_cob_id, store)
        self._server.network = _SdoWire(send)

    def on_request(self, data: bytes) -> None:
        if len(data) < _FEWEST_REQUEST_BYTES:
            return  # no SDO: CiA 301 frames have eight bytes
        try:
            self._server.on_request(self.request_cob_id, bytearray(data), 0.0)
        except Exception:  # a segment without a transfer makes the server's own abort fail
            self._send(self._answer_cob_id, struct.pack("<BHBI", 0x80, 0, 0, GENERAL_ERROR))
        if len(self._server._buffer or b"") > _LONGEST_DOWNLOAD:
            self._server._buffer = bytearray()


class _SdoWire:
    """The part of canopen's Network that its SdoServer uses."""

    def __init__(self, send: Send) -> None:
        self._send = send

    def send_message(self, can_id: int, data: bytes) -> None:
        self._send(can_id, bytes(data))
