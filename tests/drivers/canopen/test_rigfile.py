"""The shipped rig on real buses: the same arm as ornl_testbed, and every CAN device of it against simulated nodes on a virtual bus."""

from __future__ import annotations

import time

import pytest

from config.loading.load import load_rig, rig_from_text
from drivers import registry
from drivers.canopen.valve_408 import ValveDriver
from drivers.contract import Quality
from tests.support.drivers.local_nodes import EncoderNode, IoNode, NodeBench, ValveNode

CAN = load_rig("ornl_testbed_can")


def test_arm_servo_limits_and_plant_are_those_of_the_simulated_rig() -> None:
    simulated = load_rig("ornl_testbed").rig
    for section in ("arm", "loop", "joints", "servo", "link_mode", "interlocks", "plant"):
        assert getattr(CAN.rig, section) == getattr(simulated, section), section
    assert set(CAN.rig.signals) == set(simulated.signals)


def test_the_plant_section_is_the_same_text() -> None:
    def plant(text: str) -> str:
        return text[text.index("\nplant:\n") :]

    assert plant(CAN.text) == plant(load_rig("ornl_testbed").text)


@pytest.mark.device_clock
def test_every_can_device_of_the_rig_comes_up_and_is_read(bench: NodeBench) -> None:
    rig = rig_from_text(CAN.text.replace("interface: socketcan, channel: can0", f"interface: virtual, channel: '{bench.channel}'"))
    rotary, prismatic, tip = EncoderNode(bench, 1), EncoderNode(bench, 2), IoNode(bench, 3)
    rotary.local.data_store[0x6501] = {0: (72000).to_bytes(4, "little")}
    prismatic.local.data_store[0x6501] = {0: (25000).to_bytes(4, "little")}
    valves = [ValveNode(bench, 11), ValveNode(bench, 12)]
    rotary.position, prismatic.position, tip.inputs = 36000, 40640, [5000, -3, 0, 0]
    names = [name for name, device in rig.devices.items() if device.driver.startswith("canopen")]
    drivers = {name: registry.create(name, rig.devices[name], rig, lockstep=False) for name in names}
    for driver in drivers.values():
        driver.open()
        driver.configure()
    for driver in drivers.values():
        driver.activate()
    for _ in range(12):
        now = time.monotonic_ns()
        samples = {name: list(driver.read(now)) for name, driver in drivers.items()}
        for driver in drivers.values():
            if isinstance(driver, ValveDriver):
                driver.write([0.125], now)
        bench.settle()
    assert [samples["rotary_encoder"][0].raw, samples["prismatic_encoder"][0].raw] == [36000, 40640]
    assert [sample.raw for sample in samples["tip_sensors"]] == [5000, -3]
    assert all(sample.quality == Quality.GOOD for device in samples.values() for sample in device)
    assert [valve.spool for valve in valves] == [2048, 2048]
    for driver in drivers.values():
        driver.close()
    assert [valve.device_state for valve in valves] == ["DISABLED", "DISABLED"]
