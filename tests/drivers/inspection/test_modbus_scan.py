"""pymodbus' own server and a serial line: units are found by reading alone, and devices on one line ask in turns."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from config.errors import DriverError
from config.options.modbus_options import RtuOptions, TcpOptions
from drivers.contract import Quality
from drivers.inspection import modbus_scan
from drivers.inspection.modbus_scan import LinkScan, refuse_used, scan_units
from drivers.inspection.sources import UnitSource
from tests.support.drivers.modbus_gauge import UNIT, VALUES, Gauge, modbus_driver
from tests.support.drivers.modbus_slave import Slave

READS = {3, 4}


@pytest.fixture
def gauge() -> Iterator[Gauge]:
    made = Gauge()
    made.start()
    yield made
    made.stop()


@pytest.fixture
def slave() -> Iterator[Slave]:
    made = Slave(units=(3, 17))
    yield made
    made.close()


def tcp(port: int, **changes: object) -> TcpOptions:
    plain = {"transport": "tcp", "host": "127.0.0.1", "port": port, "answer_timeout": "1 s", "channels": {"r": {"address": 0}}}
    return TcpOptions.model_validate(plain | changes)


def rtu(slave: Slave, **changes: object) -> RtuOptions:
    line = {"transport": "rtu", "port": slave.port, "baud_rate": 115200, "parity": "none", "answer_timeout": "100 ms"}
    return RtuOptions.model_validate(line | {"channels": {"r": {"address": 2}}} | changes)


def scanned(options: TcpOptions | RtuOptions, units: range) -> LinkScan:
    (found,) = scan_units([options], units, lambda _: None)
    return found


def test_the_unit_of_a_server_is_found_and_only_read(gauge: Gauge) -> None:
    found = scanned(tcp(gauge.port), range(1, 6))
    assert (found.problem, [unit.options.unit_id for unit in found.units]) == ("", [UNIT])
    assert found.units[0].tables == {"input": str(gauge.registers["input"][0]), "holding": str(gauge.registers["holding"][0])}
    assert {function for function, _, _ in gauge.requests} <= READS


def test_a_closed_port_says_so(gauge: Gauge) -> None:
    gauge.stop()
    found = scanned(tcp(gauge.port), range(1, 3))
    assert found.problem.startswith("no connection")
    assert found.units == ()
    with pytest.raises(DriverError) as refusal:
        UnitSource(tcp(gauge.port))
    advice = f"Check cable, power and address; `longreach device scan tcp:127.0.0.1:{gauge.port}` shows who answers there."
    assert str(refusal.value) == f"127.0.0.1:{gauge.port}, unit 1 cannot be reached: no connection. {advice}"


def test_units_on_a_serial_line_are_found(slave: Slave) -> None:
    found = scanned(rtu(slave), range(1, 20))
    assert [unit.options.unit_id for unit in found.units] == [3, 17]
    assert slave.functions == READS


def test_two_devices_on_one_line_share_it_and_never_collide(slave: Slave) -> None:
    """Each polled in its own thread, as the I/O process does."""
    slave.registers[2] = 1234
    plain = {"transport": "rtu", "port": slave.port, "baud_rate": 115200, "parity": "none", "answer_timeout": "1 s"}
    drivers = [modbus_driver(plain | {"unit_id": unit, "channels": {"p": {"address": 2}}}, f"unit{unit}") for unit in (3, 17)]
    for driver in drivers:
        driver.open()
        driver.configure()
    seen: dict[str, list[tuple[float, Quality]]] = {driver.name: [] for driver in drivers}

    def poll(number: int) -> None:
        for cycle in range(20):
            (sample,) = drivers[number].read(cycle * 10**9)
            seen[drivers[number].name].append((sample.raw, Quality(sample.quality)))

    threads = [threading.Thread(target=poll, args=(number,)) for number in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
    assert seen == {"unit3": [(1234.0, Quality.GOOD)] * 20, "unit17": [(1234.0, Quality.GOOD)] * 20}
    assert slave.broken == 0, "no request was cut by another one"
    drivers[0].close()
    assert drivers[1].read(10**12)[0].quality is Quality.GOOD, "closing one leaves the line to the other"
    drivers[1].close()


def test_a_dead_unit_does_not_take_the_line_from_its_neighbour(slave: Slave) -> None:
    plain = {"transport": "rtu", "port": slave.port, "baud_rate": 115200, "parity": "none", "answer_timeout": "50 ms"}
    dead, alive = (modbus_driver(plain | {"unit_id": unit, "channels": {"p": {"address": 2}}}, f"unit{unit}") for unit in (99, 17))
    dead.open()
    alive.open()
    for cycle in range(3):
        now = cycle * 10**10
        assert dead.read(now)[0].quality is Quality.BAD
        assert alive.read(now)[0].quality is Quality.GOOD
    dead.close()
    alive.close()


def test_where_a_daemon_asks_nobody_else_does(gauge: Gauge, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(modbus_scan, "holder", lambda link: 4711)
    assert scanned(tcp(gauge.port), range(1, 3)).problem == "process 4711 of longreach asks the devices there: not asked"
    with pytest.raises(DriverError, match="process 4711"):
        UnitSource(tcp(gauge.port))
    assert gauge.requests == []


def test_an_open_driver_claims_its_address(gauge: Gauge) -> None:
    driver = modbus_driver(gauge.options())
    driver.open()
    with pytest.raises(DriverError, match="a daemon asks the devices there"):
        refuse_used(tcp(gauge.port))
    driver.close()
    refuse_used(tcp(gauge.port))


def test_registers_are_read_by_the_drivers_own_code(gauge: Gauge) -> None:
    channels = gauge.options()["channels"]
    source = UnitSource(tcp(gauge.port, unit_id=UNIT, channels=channels))
    try:
        assert source.read() == [value for *_, value in VALUES.values()]
        assert source.problems() == []
    finally:
        source.close()


def test_a_port_that_does_not_exist_is_named(slave: Slave) -> None:
    found = scanned(rtu(slave).model_copy(update={"port": "/dev/nosuch"}), range(1, 3))
    assert found.problem == "no connection: there is no /dev/nosuch, `ls /dev/tty*` shows the ports"
