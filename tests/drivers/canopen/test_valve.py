"""CiA 408 valve: taken up and down its states, supervised, made safe; and what is said when it does not obey."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest

from config.errors import DriverError
from drivers.canopen.valve_408 import ValveDriver
from drivers.contract import Quality
from tests.support.drivers.canopen_rig import proven, valve
from tests.support.drivers.local_nodes import NodeBench, ValveNode

pytestmark = pytest.mark.clock  # a device in a thread of its own must change its state within 50 ms

Pair = tuple[ValveNode, ValveDriver]


@pytest.fixture
def pair(bench: NodeBench) -> Iterator[Pair]:
    node = ValveNode(bench, 11)
    driver = valve(bench.channel, 11)
    driver.open()
    driver.configure()
    yield node, driver
    node.silent, node.stuck = False, False
    driver.close()


def cycle(pair: Pair, opening: float | None = None) -> None:
    """One cycle of the loop, with everything on the bus handled by the node."""
    node, driver = pair
    now = time.monotonic_ns()
    driver.read(now)
    if opening is not None:
        driver.write([opening], now)
    node.bench.settle()


def cycles(pair: Pair, number: int, opening: float | None = None) -> None:
    for _ in range(number):
        cycle(pair, opening)


def test_everything_is_set_up_in_the_device(pair: Pair) -> None:
    node, _ = pair
    assert node.state == "OPERATIONAL"
    assert node.get(0x1016, 1) == 127 * 65536 + 60
    assert node.get(0x1017) == 20
    assert node.get(0x1029, 1) == 1
    assert (node.get(0x2830, 75), node.get(0x2830, 77)) == (2, 2)
    assert (node.get(0x6042), node.get(0x6043), node.get(0x6314, 1)) == (1, 2, 0)
    assert (node.get(0x1400, 1), node.get(0x1400, 2), node.get(0x1400, 5)) == (0x200 + 11, 255, 60)
    assert (node.get(0x1800, 1), node.get(0x1800, 2)) == (0x180 + 11, 1)


def test_first_state_after_activate_holds_and_the_first_write_makes_it_active(pair: Pair) -> None:
    node, driver = pair
    driver.activate()
    assert node.device_state == "HOLD"
    cycle(pair, 0.25)
    assert node.device_state == "ACTIVE"
    assert node.set_point == 4096


@pytest.mark.parametrize(("opening", "counts"), [(0.0, 0), (1.0, 16384), (-1.0, -16384), (0.5, 8192), (7.0, 16384), (-7.0, -16384)])
def test_set_point_in_counts(pair: Pair, opening: float, counts: int) -> None:
    node, driver = pair
    driver.activate()
    cycle(pair, opening)
    assert node.set_point == counts
    cycle(pair, opening)
    cycle(pair, opening)
    spool, status = driver.read(time.monotonic_ns())
    assert spool.raw == counts
    assert int(status.raw) & 15 == 15
    assert spool.quality == Quality.GOOD


@pytest.mark.parametrize("start", ["INIT", "DISABLED", "HOLD", "ACTIVE", "FAULT_INIT", "FAULT_DISABLED", "FAULT_HOLD"])
def test_activate_from_every_state(pair: Pair, start: str) -> None:
    node, driver = pair
    node.device_state = start
    driver.activate()
    assert node.device_state == "HOLD"
    cycle(pair, 0.1)
    assert node.device_state == "ACTIVE"


@pytest.mark.parametrize("start", ["INIT", "DISABLED", "HOLD", "ACTIVE", "FAULT_INIT", "FAULT_DISABLED", "FAULT_HOLD"])
@pytest.mark.parametrize("safe_state", ["disabled", "hold"])
def test_safe_from_every_state(bench: NodeBench, start: str, safe_state: str) -> None:
    node = ValveNode(bench, 11)
    driver = valve(bench.channel, 11, safe_state=safe_state)
    driver.open()
    driver.configure()
    driver.activate()
    node.device_state = start
    driver.safe()
    cycles((node, driver), 15)
    goal = {"disabled": "DISABLED", "hold": "HOLD"}[safe_state]
    assert node.device_state == (start if start.startswith("FAULT") else goal)
    assert node.set_point == 0
    driver.close()


def test_a_fault_is_not_reset_in_the_loop(pair: Pair) -> None:
    node, driver = pair
    driver.activate()
    cycle(pair, 0.1)
    node.words.clear()
    node.device_state = "FAULT_DISABLED"
    with pytest.raises(DriverError, match=r"valve: node 11: the valve is in state FAULT_DISABLED: 11 cycles in a row \(limit: 10\)"):
        cycles(pair, 30, 0.1)
    assert not any(word & 0b1000 for word in node.words)
    assert driver.read(time.monotonic_ns())[0].quality == Quality.BAD


def test_a_wrong_state_is_bad_at_once_and_an_error_after_ten_cycles(pair: Pair) -> None:
    node, driver = pair
    driver.activate()
    for _ in range(3):
        cycle(pair, 0.1)
    node.stuck, node.device_state = True, "DISABLED"
    cycle(pair, 0.1)
    cycle(pair, 0.1)
    assert driver.read(time.monotonic_ns())[0].quality == Quality.BAD
    with pytest.raises(DriverError, match=r"in state DISABLED: 11 cycles in a row"):
        cycles(pair, 12, 0.1)
    node.bench.settle()
    assert node.words[-1] == 0b001
    assert node.set_point == 0


def test_a_silent_valve_is_an_error(pair: Pair) -> None:
    node, driver = pair
    driver.activate()
    cycle(pair, 0.1)
    node.silent = True
    with pytest.raises(DriverError, match="the valve is silent"):
        cycles(pair, 20, 0.1)
    driver.safe()
    with pytest.raises(DriverError, match=r"did not confirm that it is safe: the valve is silent\. .*60 ms.*take the pressure off"):
        cycles(pair, 20)
    cycles(pair, 20)  # told once


def test_a_persistent_fault_refuses_to_activate(pair: Pair) -> None:
    node, driver = pair
    node.device_state, node.no_reset = "FAULT_HOLD", True
    with pytest.raises(DriverError, match=r"did not follow: FAULT_HOLD \(limit: HOLD\)"):
        driver.activate()
    with pytest.raises(DriverError, match="activ"):
        driver.write([0.1], time.monotonic_ns())


def test_no_activation_without_configuration(bench: NodeBench) -> None:
    driver = valve(bench.channel, 11)
    driver.open()
    with pytest.raises(DriverError, match="not configured"):
        driver.activate()
    driver.close()


def test_an_idle_valve_is_told_to_stay_safe_in_every_cycle(pair: Pair) -> None:
    node = pair[0]
    cycle(pair)
    node.words.clear()
    for _ in range(5):
        cycle(pair)
    assert node.words == [0b001] * 5


@pytest.mark.device_clock
def test_the_valve_goes_safe_by_itself_when_the_loop_stops(pair: Pair) -> None:
    """Nobody calls the driver any more: the device's own supervision acts within its time-out."""
    node, driver = pair
    driver.activate()
    for _ in range(3):
        cycle(pair, 0.5)
    stopped = time.monotonic()
    node.bench.wait_for(lambda: node.device_state == "FAULT_DISABLED", 1.0)
    assert time.monotonic() - stopped < 0.06 + 0.05
    assert node.spool == 0


@pytest.mark.device_clock
def test_proof_of_the_safe_state(pair: Pair) -> None:
    node, driver = pair
    results = proven(driver)
    assert [result.name for result in results] == [
        "valve: spool safe after a missed heartbeat",
        "valve: spool safe after missing set points",
    ]
    assert all(result.ok for result in results), [result.text for result in results]
    assert all(0.05 < result.time_to_safe_s <= result.limit_s for result in results)
    assert node.device_state == "DISABLED"
    driver.activate()
    cycle(pair, 0.1)
    assert node.device_state == "ACTIVE"


@pytest.mark.device_clock
@pytest.mark.parametrize("reaction", [0, 1])
def test_a_valve_that_ignores_the_loss_of_its_master_fails_the_proof(bench: NodeBench, reaction: int) -> None:
    node = ValveNode(bench, 11)
    driver = valve(bench.channel, 11, fault_reactions={75: reaction, 77: 2})
    driver.open()
    driver.configure()
    first, second = proven(driver)
    assert not first.ok
    assert "not safe within 90 ms (state ACTIVE, spool 10.0 %)" in first.text
    assert second.ok
    assert node.device_state == "DISABLED"
    driver.close()


@pytest.mark.device_clock
def test_a_sticking_spool_fails_the_proof(pair: Pair) -> None:
    node, driver = pair
    node.sticky_spool = True
    result = proven(driver)[0]
    assert not result.ok
    assert "not proven, the spool did not open to 10 % (state ACTIVE, spool 26.4 %)" in result.text


@pytest.mark.device_clock
def test_the_state_alone_can_be_proven(bench: NodeBench) -> None:
    """Without pilot pressure the spool cannot open."""
    node = ValveNode(bench, 11)
    node.sticky_spool, node.STICKING = True, 0
    driver = valve(bench.channel, 11, proof_spool=0)
    driver.open()
    driver.configure()
    assert [result.ok for result in proven(driver)] == [True, True]
    driver.close()


@pytest.mark.parametrize(
    ("index", "sub", "text"),
    [
        (
            0x2830,
            75,
            r"object 0x2830 sub-index 75 \(fault reaction\) does not hold what it must: found 3 \(0x3\) \(limit: wanted 2 \(0x2\)\)",
        ),
        (0x1016, 1, r"object 0x1016 sub-index 1 \(heartbeat consumer.*found 0 \(0x0\) \(limit: wanted 8323132 \(0x7F003C\)\)"),
        (0x1600, 2, r"object 0x1600 sub-index 2 \(RPDO1 mapped object 2\).*limit: wanted 1660944656 \(0x63000110\)"),
    ],
)
def test_a_setting_that_is_not_kept_refuses_the_valve(bench: NodeBench, index: int, sub: int, text: str) -> None:
    node = ValveNode(bench, 11)
    stubborn(node, index, sub, 3 if index == 0x2830 else 0)
    driver = valve(bench.channel, 11)
    driver.open()
    with pytest.raises(DriverError, match="valve: node 11: " + text):
        driver.configure()
    with pytest.raises(DriverError, match="not configured"):
        driver.activate()
    driver.close()


def stubborn(node: ValveNode, index: int, sub: int, value: int) -> None:
    """The node accepts writes to this object and goes on saying `value`."""
    node.local.add_read_callback(lambda **asked: value if (asked["index"], asked["subindex"]) == (index, sub) else None)


def test_a_node_that_is_not_there_is_named(bench: NodeBench) -> None:
    driver = valve(bench.channel, 42)
    driver.open()
    with pytest.raises(
        DriverError, match=r"valve: node 42: did not answer about object 0x1017 sub-index 0\. Check its supply, cable, node number"
    ):
        driver.configure()
    driver.close()


def test_an_object_that_is_refused_is_named_with_the_devices_reason(bench: NodeBench) -> None:
    node = ValveNode(bench, 11)
    node.local.object_dictionary[0x6043].access_type = "ro"
    driver = valve(bench.channel, 11)
    driver.open()
    with pytest.raises(DriverError, match=r"refused 2 \(0x2\) for object 0x6043 sub-index 0 \(control mode\).*0x06010002"):
        driver.configure()
    driver.close()
