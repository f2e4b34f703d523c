"""The one contract test, with the shipped drivers against simulated nodes."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest

from drivers.contract import Driver
from drivers.driver_contract import DriverContract, OutputContract, Outputs
from tests.support.drivers.canopen_rig import encoder, io_module, valve
from tests.support.drivers.local_nodes import EncoderNode, IoNode, NodeBench, ValveNode

pytestmark = pytest.mark.clock  # a device in a thread of its own must change its state within 50 ms


class OnTheBus(DriverContract):
    """A bench for every test; leaves no driver open behind."""

    @pytest.fixture(autouse=True)
    def _bench(self, bench: NodeBench) -> Iterator[None]:
        self.bench = bench
        self.made: list[Driver] = []
        self.prepare()
        yield
        for driver in self.made:
            driver.close()

    def prepare(self) -> None:
        """For subclasses: put the node on the bench."""

    def kept(self, driver: Driver) -> Driver:
        self.made.append(driver)
        return driver


class TestEncoder406(OnTheBus):
    def prepare(self) -> None:
        EncoderNode(self.bench, 3)

    def make(self) -> Driver:
        return self.kept(encoder(self.bench.channel, 3))


class TestValve408(OnTheBus, OutputContract):
    """The spool of the node, past the protocol; it follows the set point in ACTIVE only."""

    safe_outputs = (0.0,)

    def prepare(self) -> None:
        self.node = ValveNode(self.bench, 11)

    def make(self) -> Driver:
        return self.kept(valve(self.bench.channel, 11))

    def actual_outputs(self, driver: Driver) -> Outputs:
        self.bench.settle()
        return (self.node.spool / 16384,)


class TestIo401(OnTheBus, OutputContract):
    safe_outputs = (0.0, 0.0)

    def prepare(self) -> None:
        self.node = IoNode(self.bench, 21)

    def make(self) -> Driver:
        return self.kept(io_module(self.bench.channel, 21, outputs=2, counts_per_volt=3200))

    def actual_outputs(self, driver: Driver) -> Outputs:
        self.bench.settle()
        return tuple(counts / 3200 for counts in self.node.terminals[:2])


def test_devices_on_one_channel_share_the_bus_and_one_sync(bench: NodeBench) -> None:
    nodes = [EncoderNode(bench, 1), EncoderNode(bench, 2)]
    drivers = [encoder(bench.channel, 1), encoder(bench.channel, 2)]
    syncs: list[int] = []
    bench.network.subscribe(0x080, lambda cob_id, data, stamp: syncs.append(cob_id))
    for driver in drivers:
        driver.open()
        driver.configure()
    bench.settle()
    syncs.clear()
    for number, node in enumerate(nodes, 1):
        node.position = 100 * number
    for _ in range(10):
        now = time.monotonic_ns()
        for driver in drivers:
            driver.read(now)
        bench.settle()
    assert len(syncs) == 10
    assert [driver.read(time.monotonic_ns())[0].raw for driver in drivers] == [100, 200]
    for driver in drivers:
        driver.close()
    reopened = encoder(bench.channel, 1)
    reopened.open()
    reopened.close()
