"""CiA 401 analogue I/O: volts out, counts in, error values in the module, and the proof that it uses them."""

from __future__ import annotations

import time
from collections.abc import Iterator

import can
import pytest

from config.errors import DriverError
from drivers.canopen.io_401 import IoDriver
from drivers.contract import Quality
from tests.support.drivers.canopen_rig import io_module, proven
from tests.support.drivers.local_nodes import IoNode, NodeBench

pytestmark = pytest.mark.clock  # a device in a thread of its own must change its state within 50 ms

Pair = tuple[IoNode, IoDriver]


@pytest.fixture
def pair(bench: NodeBench) -> Iterator[Pair]:
    node = IoNode(bench, 21)
    driver = io_module(bench.channel, 21, outputs=2, inputs=3)
    driver.open()
    driver.configure()
    yield node, driver
    node.silent = False
    node.local.nmt.state = "OPERATIONAL"
    driver.close()


def cycle(pair: Pair, volts: list[float] | None = None) -> None:
    node, driver = pair
    now = time.monotonic_ns()
    driver.read(now)
    if volts is not None:
        driver.write(volts, now)
    node.bench.settle()


def cycles(pair: Pair, number: int, volts: list[float] | None = None) -> None:
    for _ in range(number):
        cycle(pair, volts)


def test_error_values_are_in_the_module_before_anything_moves(pair: Pair) -> None:
    node, _ = pair
    assert [(node.get(0x6443, sub), node.get(0x6444, sub)) for sub in (1, 2)] == [(1, 0), (1, 0)]
    assert node.get(0x1029, 1) == 0
    assert node.get(0x1016, 1) == 127 * 65536 + 60
    assert (node.get(0x1401, 1), node.get(0x1401, 5), node.get(0x1801, 1)) == (0x300 + 21, 60, 0x280 + 21)


@pytest.mark.parametrize(
    ("volts", "counts"), [(0.0, 0), (10.0, 32767), (-10.0, -32767), (5.0, 16384), (25.0, 32767), (-25.0, -32767), (1e-3, 3)]
)
def test_volts_become_counts(pair: Pair, volts: float, counts: int) -> None:
    node, driver = pair
    driver.activate()
    cycle(pair, [volts, -volts])
    assert node.terminals[0] == pytest.approx(counts, abs=1)
    assert node.terminals[1] == pytest.approx(-counts, abs=1)


def test_inputs_are_the_counts_of_the_module(pair: Pair) -> None:
    node, driver = pair
    node.inputs = [1, -32768, 32767, 99]
    cycle(pair)
    cycle(pair)
    samples = driver.read(time.monotonic_ns())
    assert driver.inputs == ("input_1", "input_2", "input_3")
    assert [sample.raw for sample in samples] == [1, -32768, 32767]
    assert all(sample.quality == Quality.GOOD for sample in samples)


@pytest.mark.device_clock
def test_the_module_takes_its_error_values_when_the_loop_stops(pair: Pair) -> None:
    node, driver = pair
    driver.activate()
    for _ in range(3):
        cycle(pair, [2.0, -3.0])
    assert node.terminals[:2] != [0, 0]
    stopped = time.monotonic()
    node.bench.wait_for(lambda: node.terminals[:2] == [0, 0], 1.0)
    assert time.monotonic() - stopped < 0.06 + 0.05


def test_a_module_that_left_operational_has_bad_inputs_and_raises(pair: Pair) -> None:
    node, driver = pair
    driver.activate()
    cycles(pair, 3, [1.0, 1.0])
    node.local.nmt.stop_heartbeat()  # on a slow machine the next one, 20 ms later, would say it before 11 cycles have passed
    node.local.nmt.state = "PRE-OPERATIONAL"
    with pytest.raises(DriverError, match=r"io: node 21: the module is silent or not operational.*11 cycles in a row \(limit: 10\)"):
        cycles(pair, 60, [1.0, 1.0])
    assert [sample.quality for sample in driver.read(time.monotonic_ns())] == [Quality.BAD] * 3


def test_activate_starts_a_module_again_with_zero_volts(pair: Pair) -> None:
    node, driver = pair
    driver.activate()
    cycles(pair, 3, [2.0, 2.0])
    node.local.nmt.state = "PRE-OPERATIONAL"
    driver.activate()
    node.bench.settle()
    assert node.state == "OPERATIONAL"
    assert node.terminals[:2] == [0, 0]


def test_a_silent_module_is_told_about_when_made_safe(pair: Pair) -> None:
    node, driver = pair
    driver.activate()
    node.silent = True
    driver.safe()
    with pytest.raises(DriverError, match=r"did not confirm that it is safe.*60 ms after our last frame"):
        cycles(pair, 20)
    with pytest.raises(DriverError, match="does not become operational"):
        driver.activate()


@pytest.mark.device_clock
def test_proof_of_the_error_values(pair: Pair) -> None:
    node, driver = pair
    results = proven(driver)
    assert [result.ok for result in results] == [True, True], [result.text for result in results]
    assert all(0.05 < result.time_to_safe_s <= result.limit_s == pytest.approx(0.09) for result in results)
    assert node.terminals[:2] == [0, 0]


def test_inputs_count_while_the_module_leaves_operational_in_its_own_proof(pair: Pair, bench: NodeBench) -> None:
    """It does as it should then; the supply pressure may be one of them, and is asked for during the proof."""
    node, driver = pair
    proof = driver.prove_safe_state()
    for _ in range(5):
        cycle(pair)
        next(proof)
    node.local.nmt.stop_heartbeat()  # it would be late on a slow machine: the one below says what it would say
    node.local.nmt.state = "PRE-OPERATIONAL"
    bench.bus.send(can.Message(arbitration_id=0x700 + 21, is_extended_id=False, data=[127]))
    node.bench.settle()
    samples = driver.read(time.monotonic_ns())
    assert driver.nmt_state == 127
    assert len(samples) == 3
    assert all(sample.quality != Quality.BAD for sample in samples)
    proof.close()
    driver.safe()
    assert [sample.quality for sample in driver.read(time.monotonic_ns())] == [Quality.BAD] * 3


class KeepsItsVoltage(IoNode):
    @property
    def terminals(self) -> list[int]:
        return self.written


def wired(bench: NodeBench, kind: type[IoNode] = IoNode) -> Pair:
    node = kind(bench, 21)
    node.wired = {1: 3}
    driver = io_module(bench.channel, 21, outputs=2, inputs=3, loopback={1: 3})
    driver.open()
    driver.configure()
    return node, driver


@pytest.mark.device_clock
def test_proof_with_a_wire_from_output_to_input_measures_the_voltage(bench: NodeBench) -> None:
    _, driver = wired(bench)
    results = proven(driver)
    assert [result.ok for result in results] == [True, True], [result.text for result in results]
    assert "input_3 0 counts" in results[0].text
    driver.close()


@pytest.mark.device_clock
def test_a_module_that_keeps_its_voltage_fails_the_proof(bench: NodeBench) -> None:
    """It says all the right things and goes on driving the valve: only the wire shows it."""
    node, driver = wired(bench, KeepsItsVoltage)
    result = proven(driver)[0]
    assert node.state == "OPERATIONAL"
    assert not result.ok
    assert "input_3 1638 counts" in result.text
    driver.close()


@pytest.mark.device_clock
def test_a_broken_wire_is_no_proof(bench: NodeBench) -> None:
    node, driver = wired(bench)
    node.wired = {}
    result = proven(driver)[0]
    assert not result.ok
    assert "not proven, input and output wired together differ" in result.text
    driver.close()


def test_a_module_used_for_its_inputs_only(bench: NodeBench) -> None:
    """No outputs are written, nothing supervises us, and the inputs come at every fourth SYNC."""
    node = IoNode(bench, 21)
    node.inputs = [7, 8, 0, 0]
    driver = io_module(bench.channel, 21, outputs=0, inputs=2, every_syncs=4)
    driver.open()
    driver.configure()
    assert proven(driver) == []
    driver.activate()
    cycles((node, driver), 12)
    assert node.get(0x1016, 1) == 0
    assert node.heard_set_point is None
    received = driver.received
    qualities = set()
    for _ in range(20):
        cycle((node, driver))
        qualities.add(driver.read(time.monotonic_ns())[0].quality)
    assert qualities == {Quality.GOOD}
    assert driver.received - received == 10  # two reads, so two SYNC, a turn
    node.silent = True
    driver.safe()
    cycles((node, driver), 12)
    assert driver.read(time.monotonic_ns())[0].quality == Quality.BAD
    driver.close()
