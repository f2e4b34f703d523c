"""The twin's Modbus side read by clients that are not ours: pymodbus' client and, where it is installed, mbpoll (libmodbus)."""

from __future__ import annotations

import shutil
import socket
import subprocess
import time

import pytest
from pymodbus import ModbusException
from pymodbus.client import ModbusTcpClient

UNIT = 7


@pytest.fixture
def client(running):
    client = ModbusTcpClient("127.0.0.1", port=running.modbus_port, timeout=1.0, retries=0)
    assert client.connect()
    yield client
    client.close()


def engineering(running, signal: str, count: float) -> float:
    calibration = running.rig.signals[signal].calibration
    return calibration.offset + calibration.scale * count


def reading(client) -> int:
    """Of the rotary joint's supply pressure."""
    return client.read_input_registers(0, count=1, device_id=UNIT).registers[0]


def test_every_type_and_word_order_against_the_plant(running, client) -> None:
    kinds = client.DATATYPE
    plant = running.twin.bench.feed.plant
    reads = {
        "rotary.supply_pressure": (client.read_input_registers, 0, 1, kinds.UINT16, "big", 0.02 * 14e6),
        "rotary.return_pressure": (client.read_input_registers, 1, 1, kinds.INT16, "big", 0.2e6),
        "prismatic.supply_pressure": (client.read_input_registers, 10, 2, kinds.UINT32, "little", 0.02 * 14e6),
        "prismatic.return_pressure": (client.read_input_registers, 12, 2, kinds.INT32, "big", 0.2e6),
        "rotary.supply_temperature": (client.read_holding_registers, 100, 2, kinds.FLOAT32, "big", 1.0),
        "rotary.return_temperature": (client.read_holding_registers, 102, 2, kinds.FLOAT32, "little", 1.0),
        "reservoir_temperature": (client.read_input_registers, 14, 1, kinds.INT16, "big", 1.0),
    }
    for signal, (ask, address, count, kind, order, near) in reads.items():
        registers = ask(address, count=count, device_id=UNIT).registers
        value = engineering(running, signal, client.convert_from_registers(registers, kind, word_order=order))
        assert value == pytest.approx(plant.true_signal(signal), abs=near), signal


def test_exceptions_for_other_addresses_units_and_writes(running, client) -> None:
    assert client.read_input_registers(500, count=1, device_id=UNIT).exception_code == 2
    assert client.write_register(100, 1, device_id=UNIT).isError()
    assert client.read_input_registers(0, count=1, device_id=9).isError()


@pytest.mark.device_clock
def test_faults_of_a_unit(running, client) -> None:
    control = running.control
    control.inject("gauges", "exception", 6)
    assert client.read_input_registers(0, count=1, device_id=UNIT).exception_code == 6
    control.clear("gauges")
    before = reading(client)
    control.inject("gauges", "jump", 500)
    jumped = reading(client)
    control.clear("gauges")
    low, high = sorted((before, reading(client)))  # the pressure itself moves from one reading to the next on a machine that is busy
    assert low - 30 <= jumped - 500 <= high + 30
    control.inject("gauges", "slow", 80)
    start = time.monotonic()
    assert not client.read_input_registers(0, count=1, device_id=UNIT).isError()
    assert time.monotonic() - start >= 0.08


def test_black_hole_and_dead_unit_and_their_return(running, client) -> None:
    running.control.inject("gauges", "black_hole")
    with pytest.raises(ModbusException):
        client.read_input_registers(0, count=1, device_id=UNIT)
    running.control.clear()
    running.control.inject("gauges", "dead")
    running.eventually(lambda: not listens(running.modbus_port), "nobody listens")
    running.control.clear()
    running.eventually(lambda: listens(running.modbus_port), "it is back")
    client.close()
    assert client.connect()
    assert not client.read_input_registers(0, count=1, device_id=UNIT).isError()


def listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def test_stuck_values_stay_while_the_supply_is_lost(running, client) -> None:
    before = client.read_input_registers(0, count=1, device_id=UNIT).registers[0]
    running.control.inject("gauges", "stuck")
    running.control.inject("plant", "supply_pressure", 0.0)
    running.eventually(lambda: running.twin.bench.feed.plant.true_signal("rotary.supply_pressure") < 1e6, "the supply falls")
    assert client.read_input_registers(0, count=1, device_id=UNIT).registers[0] == pytest.approx(before, abs=80)  # noise: 11 a reading
    running.control.clear("gauges")
    running.eventually(lambda: client.read_input_registers(0, count=1, device_id=UNIT).registers[0] < before // 2, "it shows now")
    running.control.inject("plant", "oil_temperature", 80.0)
    hot = running.rig.signals["reservoir_temperature"]

    def shown_C() -> float:
        return hot.calibration.scale * client.read_input_registers(14, count=1, device_id=UNIT).registers[0]

    running.eventually(lambda: shown_C() > 45, "the sensor follows, with its lag of seconds")


@pytest.mark.skipif(shutil.which("mbpoll") is None, reason="mbpoll is not installed (apt-get install mbpoll)")
def test_mbpoll_reads_the_same_registers(running, client) -> None:
    def read() -> list[int]:
        return client.read_input_registers(0, count=2, device_id=UNIT).registers

    before = [read() for _ in range(5)]
    result = mbpoll(running.modbus_port, address=0)
    assert result.returncode == 0, result.stdout + result.stderr
    theirs = [int(line.split("\t")[-1].split()[0]) for line in result.stdout.splitlines() if line.startswith("[")]
    ours = [*before, *(read() for _ in range(5))]  # the pressure moves meanwhile, and every reading has its noise
    for number, values in zip(theirs, zip(*ours, strict=True), strict=True):
        assert min(values) - 30 <= number <= max(values) + 30
    refused = mbpoll(running.modbus_port, address=900)
    assert "Illegal data address" in refused.stdout + refused.stderr


def mbpoll(port: int, address: int) -> subprocess.CompletedProcess[str]:
    """Two input registers, once, addresses counted from 0."""
    options = ["-m", "tcp", "-p", str(port), "-a", str(UNIT), "-0", "-r", str(address), "-c", "2", "-t", "3", "-1"]
    return subprocess.run(["mbpoll", *options, "127.0.0.1"], capture_output=True, text=True, timeout=20, check=False)
