"""The output register of a simulated device: what its valves are told, kept outside the control process, with the device's own time-out.

A real valve amplifier goes to its safe state when nobody writes for `timeout`. The register follows the same rule, so anybody who
maps the file sees what the valves really do after the control process was killed:

    effective(now) = value            while now − stamp ≤ timeout
                     safe value       afterwards, and before the first write

A write fills the slot that is not in use and then makes it the valid one by a single 8-byte store of the sequence number, so a
kill between two stores leaves the last whole write. File (little endian, 8-byte words): magic, number of valves n, timeout in ns,
sequence; n safe values; then two slots of (stamp in ns, n values); sequence & 1 names the valid slot.
"""

from __future__ import annotations

import mmap
import os
import struct
from collections.abc import Sequence
from pathlib import Path

from config.errors import DriverError

MAGIC = 0x31525245474E4F4C  # "LONGERR1"
NEVER = -(1 << 62)  # stamp of a slot that was never written
_MAGIC, _COUNT, _TIMEOUT, _SEQUENCE, _SAFE = range(5)
_WORD = 8


class OutputRegister:
    """`create` makes a register (in a file or in memory), `attach` reads one that another process made."""

    def __init__(self, memory: mmap.mmap, valves: int) -> None:
        self._memory = memory
        self._words = memoryview(memory).cast("q")
        self._values = memoryview(memory).cast("d")
        self.valves = valves
        self._slots = (_SAFE + valves, _SAFE + valves + 1 + valves)
        self.safe_values = tuple(self._values[_SAFE : _SAFE + valves])

    @classmethod
    def create(cls, safe_values: Sequence[float], timeout_s: float, path: Path | None = None) -> OutputRegister:
        """A register with nothing written yet. Raises DriverError when the file cannot be made."""
        valves = len(safe_values)
        content = struct.pack("<qqqq", MAGIC, valves, round(timeout_s * 1e9), 0) + struct.pack(f"<{valves}d", *safe_values)
        content += 2 * struct.pack(f"<q{valves}d", NEVER, *safe_values)
        if path is None:
            memory = mmap.mmap(-1, len(content))
            memory[:] = content
            return cls(memory, valves)
        try:
            path.unlink(missing_ok=True)  # a reader of the old register keeps the old file
            path.write_bytes(content)
            return cls(_map(path, mmap.ACCESS_WRITE), valves)
        except OSError as error:
            raise DriverError("the output register cannot be made", value=error.strerror or "", where=str(path)) from error

    @classmethod
    def attach(cls, path: Path) -> OutputRegister:
        """Read-only view of another process's register. Raises DriverError when the file is no register."""
        try:
            memory = _map(path, mmap.ACCESS_READ)
            magic, valves = struct.unpack_from("<qq", memory)
        except (OSError, ValueError, struct.error) as error:
            raise DriverError("the output register cannot be read", value=str(error), where=str(path)) from error
        if magic != MAGIC or len(memory) != _WORD * (_SAFE + valves + 2 * (1 + valves)):
            raise DriverError("the file is not an output register", value=hex(magic), limit=hex(MAGIC), where=str(path))
        return cls(memory, valves)

    def write(self, values: Sequence[float], now_ns: int) -> None:
        """Set every valve and restart the time-out."""
        sequence = self._words[_SEQUENCE] + 1
        slot = self._slots[sequence & 1]
        self._words[slot] = now_ns
        for number, value in enumerate(values, slot + 1):
            self._values[number] = value
        self._words[_SEQUENCE] = sequence

    def make_safe(self) -> None:
        """Safe values at once; the time-out has nothing left to do."""
        self.write(self.safe_values, NEVER)

    @property
    def timeout_s(self) -> float:
        return self._words[_TIMEOUT] * 1e-9

    @property
    def sequence(self) -> int:
        """Number of writes so far."""
        return self._words[_SEQUENCE]

    def last_write(self) -> tuple[tuple[float, ...], int]:
        """(values, stamp in ns) of the last whole write."""
        while True:
            sequence = self._words[_SEQUENCE]
            slot = self._slots[sequence & 1]
            stamp = self._words[slot]
            values = tuple(self._values[slot + 1 : slot + 1 + self.valves])
            if self._words[_SEQUENCE] == sequence:
                return values, stamp

    def effective(self, now_ns: int) -> tuple[float, ...]:
        """What the valves do at `now_ns` (the clock that stamped the writes)."""
        values, stamp = self.last_write()
        return values if now_ns - stamp <= self._words[_TIMEOUT] else self.safe_values

    def close(self) -> None:
        self._words.release()
        self._values.release()
        self._memory.close()


def _map(path: Path, access: int) -> mmap.mmap:
    descriptor = os.open(path, os.O_RDWR if access == mmap.ACCESS_WRITE else os.O_RDONLY)
    try:
        return mmap.mmap(descriptor, 0, access=access)
    finally:
        os.close(descriptor)
