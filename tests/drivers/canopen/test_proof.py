"""Proofs of several devices on one bus, in turns; and a proof that is given up half way."""

from __future__ import annotations

import time

import pytest

from config.errors import DriverError
from drivers.proof import ProvesSafeState
from tests.support.drivers.canopen_rig import io_module, proven, valve
from tests.support.drivers.local_nodes import IoNode, NodeBench, ValveNode


@pytest.mark.device_clock
def test_devices_that_disturb_each_other_are_all_in_order_at_the_end(bench: NodeBench) -> None:
    """One missed heartbeat is missed by all on the bus: the others fault too, and must be ready again before arming looks at them."""
    nodes = [ValveNode(bench, 11), IoNode(bench, 21)]
    drivers = [valve(bench.channel, 11), io_module(bench.channel, 21, outputs=2, inputs=3)]
    for driver in drivers:
        assert isinstance(driver, ProvesSafeState)
        driver.open()
        driver.configure()
    results = proven(*drivers)
    assert [result.name for result in results] == [
        "valve: spool safe after a missed heartbeat",
        "io: outputs safe after a missed heartbeat",
        "valve: spool safe after missing set points",
        "io: outputs safe after missing set points",
    ]
    assert all(result.ok for result in results), [result.text for result in results]
    assert (nodes[0].device_state, nodes[1].state) == ("DISABLED", "OPERATIONAL")
    assert nodes[0].spool == 0
    assert nodes[1].terminals == [0, 0, 0, 0]
    for driver in drivers:
        driver.close()


@pytest.mark.device_clock
@pytest.mark.parametrize("steps", [3, 20, 60])
def test_a_proof_given_up_half_way_leaves_a_safe_valve_that_says_so(bench: NodeBench, steps: int) -> None:
    node = ValveNode(bench, 11)
    driver = valve(bench.channel, 11)
    driver.open()
    driver.configure()
    proof = driver.prove_safe_state()
    for _ in range(steps):
        driver.read(time.monotonic_ns())
        next(proof)
        bench.settle()
    proof.close()
    driver.safe()
    for _ in range(20):
        driver.read(time.monotonic_ns())
        bench.settle()
    assert node.device_state in ("DISABLED", "FAULT_DISABLED")
    assert (node.spool, node.set_point) == (0, 0)
    assert node.heard_master is not None, "our heartbeat is back"
    driver.close()


def test_a_silent_valve_cannot_be_proven(bench: NodeBench) -> None:
    node = ValveNode(bench, 11)
    driver = valve(bench.channel, 11)
    driver.open()
    driver.configure()
    node.silent = True
    with pytest.raises(DriverError, match="the valve is silent"):
        proven(driver)
    node.silent = False
    driver.close()
