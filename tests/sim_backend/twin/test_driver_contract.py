"""The one contract test: the drivers of valve, analogue module, encoder and Modbus unit, each against its twin on a virtual bus."""

from __future__ import annotations

import time

import pytest

from drivers import registry
from drivers.contract import Driver
from drivers.driver_contract import DriverContract, OutputContract, Outputs
from sim_backend.twin.can.valve_states import ValveState

pytestmark = pytest.mark.clock  # a device in a thread of its own must change its state within 50 ms

SETTLE_S = 5.0


class AgainstTheTwin(DriverContract):
    """`device` of the rig."""

    device = ""

    @pytest.fixture(autouse=True)
    def _twin(self, running):
        self.running = running
        self.made: list[Driver] = []
        yield
        for driver in self.made:
            try:
                driver.close()
            except Exception as error:  # a busy machine: the device has already made itself safe
                print(error)

    def make(self) -> Driver:
        driver = registry.create(self.device, self.running.rig.devices[self.device], self.running.rig, False)
        self.made.append(driver)
        return driver


class WithOutputs(AgainstTheTwin, OutputContract):
    """A command needs some cycles to act: a valve takes a state a cycle, and its spool a stroke."""

    def a_command(self, driver: Driver) -> list[float]:
        return [0.25 for _ in driver.outputs]

    def shown(self) -> Outputs:
        """What the device does now, rounded to its counts."""
        return ()

    def actual_outputs(self, driver: Driver) -> Outputs:
        time.sleep(0.005)  # a frame's way; a command holds for the device's time-out of 30 ms
        return self.shown()


class TestEncoder(AgainstTheTwin):
    device = "rotary_encoder"


class TestGauges(AgainstTheTwin):
    device = "gauges"


class TestValveByItsOwnAccount(WithOutputs):
    """The first write takes a valve one state up only, so a command is written until the valve is ACTIVE."""

    device = "rotary_valve"
    safe_outputs: Outputs = (0.0,)

    def make(self) -> Driver:
        driver = super().make()
        write = driver.write

        def write_until_active(values, now_ns):
            write(values, now_ns)
            valve = self.running.twin.bench.device(self.device)
            end = time.monotonic() + SETTLE_S
            while valve.device_state is not ValveState.ACTIVE:
                assert time.monotonic() < end, valve.device_state
                driver.read(time.monotonic_ns())
                write(values, time.monotonic_ns())
                time.sleep(0.001)

        driver.write = write_until_active
        return driver

    def shown(self) -> Outputs:
        return (round(self.running.twin.bench.device(self.device).demand_counts / 16384, 3),)


class TestAnalogueModule(WithOutputs):
    device = "io"
    safe_outputs: Outputs = (0.0,)

    def shown(self) -> Outputs:
        return (round(self.running.twin.bench.device(self.device).outputs[0] / 3276.7, 2),)
