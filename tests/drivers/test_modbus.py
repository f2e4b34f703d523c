"""The Modbus driver against a server made with pymodbus: the driver contract, all types, and everything that can go wrong."""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Iterator

import pytest
from pymodbus.constants import ExcCodes

from config.errors import ConfigError, DriverError
from config.loading.load import load_rig
from config.schema.rig import Device
from drivers.contract import Driver, Quality
from drivers.driver_contract import DriverContract
from drivers.registry import create
from tests.support.drivers.modbus_gauge import UNIT, VALUES, Gauge, modbus_driver

pytestmark = pytest.mark.device_clock  # the server answers within the time-out of 0.1 s, or the driver calls it silent

NO_ROUTE = "192.0.2.1"  # documentation addresses (RFC 5737) are routed nowhere


@pytest.fixture
def gauge() -> Iterator[Gauge]:
    gauge = Gauge()
    gauge.start()
    yield gauge
    gauge.stop()


@pytest.fixture
def driver(gauge: Gauge) -> Iterator[Driver]:
    driver = modbus_driver(gauge.options())
    driver.open()
    driver.configure()
    driver.activate()
    yield driver
    driver.close()


def poll(driver: Driver) -> dict[str, tuple[float, int]]:
    samples = driver.read(time.monotonic_ns())
    return {name: (sample.raw, sample.quality) for name, sample in zip(driver.inputs, samples, strict=True)}


def all_bad(driver: Driver) -> bool:
    return all(quality == Quality.BAD and math.isnan(raw) for raw, quality in poll(driver).values())


def eventually_good(driver: Driver) -> None:
    end = time.monotonic() + 5
    while all_bad(driver):
        assert time.monotonic() < end


class TestContract(DriverContract):
    @pytest.fixture(autouse=True)
    def _with_gauge(self, gauge: Gauge) -> None:
        self.gauge = gauge

    def make(self) -> Driver:
        return modbus_driver(self.gauge.options())


def test_nothing_but_reads_reaches_the_unit(gauge: Gauge, driver: Driver) -> None:
    driver.write([], time.monotonic_ns())
    driver.read(time.monotonic_ns())
    driver.safe()
    assert {function for function, *_ in gauge.requests} == {3, 4}


def test_a_command_is_refused_because_there_are_no_outputs(driver: Driver) -> None:
    with pytest.raises(DriverError, match="no outputs"):
        driver.write([0.1], time.monotonic_ns())


def test_read_after_close_says_that_it_is_not_open(driver: Driver) -> None:
    driver.close()
    with pytest.raises(DriverError, match="not open"):
        driver.read(time.monotonic_ns())


def test_every_type_and_word_order(driver: Driver) -> None:
    assert poll(driver) == {name: (value, Quality.GOOD) for name, (*_, value) in VALUES.items()}


def test_blocks_are_merged_and_far_ones_are_not(gauge: Gauge, driver: Driver) -> None:
    gauge.requests.clear()
    poll(driver)
    assert sorted(gauge.requests) == [(3, 40, 4), (3, 300, 1), (4, 0, 8)]


def test_stamp_is_the_time_of_asking(driver: Driver) -> None:
    now = time.monotonic_ns()
    assert {sample.stamp_ns for sample in driver.read(now)} == {now}


def test_float_that_is_no_number_is_bad(gauge: Gauge, driver: Driver) -> None:
    gauge.registers["holding"][40:42] = [0x7FC0, 0]
    seen = poll(driver)
    assert seen["temperature"][1] == Quality.BAD
    assert seen["speed"] == (-0.1875, Quality.GOOD)


def test_exception_code_is_bad_named_and_over_at_once(gauge: Gauge, driver: Driver) -> None:
    before = driver.read(time.monotonic_ns())[0].stamp_ns
    gauge.exception = ExcCodes.DEVICE_BUSY
    assert all_bad(driver)
    assert "exception 6 (device busy)" in driver.failure
    assert driver.read(time.monotonic_ns())[0].stamp_ns == before  # so that the age goes on growing
    gauge.exception = None
    assert not all_bad(driver)
    assert driver.failure == ""


def test_time_out_takes_no_longer_than_it_may_and_is_followed_by_a_pause(gauge: Gauge, driver: Driver) -> None:
    gauge.is_silent = True
    start = time.monotonic()
    assert all_bad(driver)
    assert 0.1 <= time.monotonic() - start < 0.25  # 100 ms, one try, one block
    gauge.requests.clear()
    start = time.monotonic()
    reads = 0
    while time.monotonic() - start < 0.04:
        assert all_bad(driver)
        reads += 1
    assert gauge.requests == []  # left alone until retry_after has passed
    assert reads > 100  # and nobody waits meanwhile
    gauge.is_silent = False
    eventually_good(driver)


def test_slow_answers_within_the_time_out_are_good(gauge: Gauge, driver: Driver) -> None:
    gauge.delay_s = 0.06
    assert not all_bad(driver)


def test_a_late_answer_is_never_taken_for_the_next_one(gauge: Gauge, driver: Driver) -> None:
    gauge.delay_s = 0.15
    assert all_bad(driver)
    gauge.delay_s = 0.0
    gauge.registers["input"][0] = 77
    eventually_good(driver)
    assert poll(driver)["pressure"] == (77, Quality.GOOD)


def test_lost_server_and_its_return(gauge: Gauge, driver: Driver) -> None:
    gauge.stop()
    assert all_bad(driver)
    connections = driver.failures
    end = time.monotonic() + 0.3
    while time.monotonic() < end:
        assert all_bad(driver)
    assert driver.failures - connections <= 0.3 / 0.05 + 1  # one try every retry_after
    gauge.start()
    eventually_good(driver)
    assert driver.failure == ""


def test_black_hole_costs_one_time_out(gauge: Gauge) -> None:
    """A listener with a full backlog takes the connection and never says anything."""
    with socket.socket() as hole:
        hole.bind(("127.0.0.1", 0))
        hole.listen(1)
        driver = modbus_driver(gauge.options(port=hole.getsockname()[1]))
        driver.open()
        start = time.monotonic()
        with pytest.raises(DriverError, match="cannot be read"):
            driver.configure()
        assert time.monotonic() - start < 0.25
        driver.close()


def test_unreachable_address_is_refused_in_time(gauge: Gauge) -> None:
    driver = modbus_driver(gauge.options(host=NO_ROUTE))
    start = time.monotonic()
    with pytest.raises(DriverError, match=f"^gauges: {NO_ROUTE}:.* cannot be reached: no connection. Check cable"):
        driver.open()
    assert time.monotonic() - start < 0.5


def test_wrong_unit_or_address_shows_in_configure(gauge: Gauge) -> None:
    for change in ({"unit_id": UNIT + 1}, {"channels": {"nowhere": {"address": 9000}}}):
        driver = modbus_driver(gauge.options(**change))
        driver.open()
        with pytest.raises(DriverError, match=r"registers .* cannot be read.*exception"):
            driver.configure()
        driver.close()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"transport": "udp"}, "transport cannot be 'udp'"),
        ({"channels": {}}, "channels"),
        ({"channels": {"p": {"address": -1}}}, "address is out of range"),
        ({"channels": {"p": {"adress": 1}}}, "nearest is 'address'"),
        ({"channels": {"p": {"address": 1, "type": "int17"}}}, "type cannot be 'int17'"),
        ({"channels": {"p": {"address": 65535, "type": "float32"}}}, "ends beyond the last register"),
        ({"channels": {"p": {"address": 4, "type": "int32"}, "q": {"address": 5}}}, "'p' and 'q' share a register"),
        ({"answer_timeout": "5 m"}, "answer_timeout"),
        ({"unit_id": 300}, "unit_id is out of range"),
        ({"host": None}, "host"),
    ],
)
def test_bad_options_are_refused_with_their_place(gauge: Gauge, options: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message) as refusal:
        modbus_driver(gauge.options(**options))
    assert "devices.gauges.options" in str(refusal.value)


def test_a_fast_modbus_device_is_refused(gauge: Gauge) -> None:
    device = Device(driver="modbus", options=gauge.options())
    with pytest.raises(ConfigError, match="must be slow"):
        create("gauges", device, load_rig("ornl_testbed").rig, False)
