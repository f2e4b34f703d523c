"""A Modbus RTU slave at the far end of a pseudo terminal: a few lines of our own that know frames and CRC from the specification."""

from __future__ import annotations

import os
import pty
import select
import struct
import threading
import tty


def crc16(data: bytes) -> int:
    """CRC-16 of Modbus over serial line (V1.02, appendix B): reflected polynomial 0xA001, start 0xFFFF."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return crc


class Slave:
    """Answers functions 3 and 4 on a pty for its units. `mode`: right, silent, exception, wrong_crc, noise.

    `functions`: those asked for; `broken`: requests whose CRC was wrong.
    """

    def __init__(self, units: tuple[int, ...] = (17,), registers: int = 20) -> None:
        self.units = units
        self.functions: set[int] = set()
        self.broken = 0
        self.master, slave = pty.openpty()
        tty.setraw(self.master)
        tty.setraw(slave)
        self.port = os.ttyname(slave)
        self._slave = slave
        self.mode = "right"
        self.registers = [0] * registers
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        self._thread.join(5)
        os.close(self.master)
        os.close(self._slave)

    def _serve(self) -> None:
        received = b""
        while not self._stop.is_set():
            if not select.select([self.master], [], [], 0.02)[0]:
                received = b""  # silence ends a frame
                continue
            received += os.read(self.master, 256)
            if len(received) >= 8:
                os.write(self.master, self._answer(received[:8]))
                received = b""

    def _answer(self, request: bytes) -> bytes:
        unit, function, address, count = struct.unpack(">BBHH", request[:6])
        if crc16(request[:6]) != struct.unpack("<H", request[6:])[0]:
            self.broken += 1
            return b""
        self.functions.add(function)
        if self.mode == "silent" or unit not in self.units:
            return b""
        if self.mode == "noise":
            return os.urandom(7)
        words = self.registers[address : address + count]
        answer = struct.pack(f">BBB{count}H", unit, function, 2 * count, *words)
        if self.mode == "exception":
            answer = struct.pack(">BBB", unit, function | 0x80, 4)
        return answer + struct.pack("<H", crc16(answer) ^ (0x0100 if self.mode == "wrong_crc" else 0))
