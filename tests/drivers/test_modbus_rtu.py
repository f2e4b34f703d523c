"""Modbus RTU over a pseudo terminal."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import pytest

from drivers.contract import Quality
from tests.support.drivers.modbus_gauge import modbus_driver
from tests.support.drivers.modbus_slave import Slave, crc16

UNIT = 17


@pytest.fixture
def slave() -> Iterator[Slave]:
    slave = Slave()
    yield slave
    slave.close()


def options(slave: Slave) -> dict[str, object]:
    channels = {"p": {"address": 2}, "t": {"address": 4, "type": "float32"}}
    line = {"transport": "rtu", "port": slave.port, "baud_rate": 115200, "parity": "none", "unit_id": UNIT}  # a pty knows no parity
    return {**line, "answer_timeout": "100 ms", "retry_after": "10 ms", "channels": channels}


@pytest.mark.device_clock
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
