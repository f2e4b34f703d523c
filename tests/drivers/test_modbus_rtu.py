"""Modbus RTU over a pseudo terminal: the far end is a few lines of our own that know frames and CRC from the specification."""

from __future__ import annotations

import os
import pty
import select
import struct
import threading
import tty
from collections.abc import Iterator

import pytest
from modbus_gauge import modbus_driver

from drivers.contract import Quality

UNIT = 17


def crc16(data: bytes) -> int:
    """CRC-16 of Modbus over serial line (V1.02, appendix B): reflected polynomial 0xA001, start 0xFFFF."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return crc


class Slave:
    """Answers function 4 on a pty. `mode`: right, silent, exception, wrong_crc, noise."""

    def __init__(self) -> None:
        self.master, slave = pty.openpty()
        tty.setraw(self.master)
        tty.setraw(slave)
        self.port = os.ttyname(slave)
        self._slave = slave
        self.mode = "right"
        self.registers = [0] * 20
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
        if self.mode == "silent" or unit != UNIT or crc16(request[:6]) != struct.unpack("<H", request[6:])[0]:
            return b""
        if self.mode == "noise":
            return os.urandom(7)
        words = self.registers[address : address + count]
        answer = struct.pack(f">BBB{count}H", unit, function, 2 * count, *words)
        if self.mode == "exception":
            answer = struct.pack(">BBB", unit, function | 0x80, 4)
        return answer + struct.pack("<H", crc16(answer) ^ (0x0100 if self.mode == "wrong_crc" else 0))


@pytest.fixture
def slave() -> Iterator[Slave]:
    slave = Slave()
    yield slave
    slave.close()


def options(slave: Slave) -> dict[str, object]:
    channels = {"p": {"address": 2}, "t": {"address": 4, "type": "float32"}}
    line = {"transport": "rtu", "port": slave.port, "baud_rate": 115200, "parity": "none", "unit_id": UNIT}  # a pty knows no parity
    return {**line, "answer_timeout": "100 ms", "retry_after": "10 ms", "channels": channels}


def test_registers_over_a_serial_line_with_every_kind_of_bad_answer(slave: Slave) -> None:
    slave.registers[2] = 0xFF85  # -123
    slave.registers[4:6] = struct.unpack(">HH", struct.pack(">f", 18.5))
    driver = modbus_driver(options(slave))
    driver.open()
    driver.configure()
    now = 0
    for mode in ("right", "silent", "right", "exception", "right", "wrong_crc", "right", "noise", "right"):
        slave.mode = mode
        now += 10**9
        qualities = {sample.quality for sample in driver.read(now)}
        assert qualities == {Quality.GOOD if mode == "right" else Quality.BAD}, (mode, driver.failure)
        if mode == "right":
            assert [sample.raw for sample in driver.read(now + 1)] == [-123.0, 18.5]
    driver.close()


def test_crc_of_this_test_is_the_published_one() -> None:
    assert crc16(b"\x02\x07") == 0x1241  # the example of the specification
