"""A hundred thousand answers of a Modbus device, right, wrong and none, through the real driver to the loop: it goes on, the arm stays."""

from __future__ import annotations

import random
import struct
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

import pytest

from config.loading.load import LoadedRig, apply_overrides, rig_from_text
from config.options.driver_options import device_options
from config.schema.rig import Device, Rig
from daemon.lockstep import LockstepRig
from daemon.modes.mode_machine import OperatorAction
from drivers.contract import Driver
from drivers.modbus import ModbusDriver
from drivers.modbus_client import ModbusReadError
from servo_control.signals import Mode
from tests.support.daemon.proving_rig import RIG
from tests.support.daemon.simple_device import SimpleDevice

GAUGES = "hydraulic_unit"
EPISODE = 500  # answers, before the arm is armed again
HEALTHY = {"supply_pressure": 14e6, "return_pressure": 0.1e6, "temperature": 40.0}


def unproven() -> LoadedRig:
    """One channel is a float over two registers, so that infinities and NaN can come."""
    changes = [f"devices.{valve}.demand_proof=false" for valve in ("rotary_valve", "prismatic_valve")]
    channel = f"devices.{GAUGES}.options.channels.reservoir_temperature"
    text = apply_overrides(
        RIG.text, [*changes, f"{channel}.type=float32", f"{channel}.address=20", f"devices.{GAUGES}.options.retry_after=10 ms"]
    )
    return LoadedRig(rig_from_text(text), text, "registers.yaml")


class Answers:
    """A connection: healthy answers, or whatever comes to mind."""

    def __init__(self, rig: Rig, seed: int) -> None:
        self._random = random.Random(seed)
        self._registers = [0] * 64
        self.is_healthy = True
        self.given = 0
        channels = device_options(GAUGES, rig.devices[GAUGES]).channels
        for name, signal in rig.signals.items():
            if signal.device != GAUGES:
                continue
            value = next(number for ending, number in HEALTHY.items() if name.endswith(ending))
            count, channel = (value - signal.calibration.offset) / signal.calibration.scale, channels[signal.channel]
            words = struct.unpack(">HH", struct.pack(">f", count)) if channel.type == "float32" else (round(count),)
            self._registers[channel.address : channel.address + len(words)] = words

    def connect(self) -> None:
        if not self.is_healthy and self._random.random() < 0.5:
            raise ModbusReadError("no connection", answered=False)

    def read(self, table: str, address: int, count: int) -> Sequence[int]:
        self.given += not self.is_healthy
        registers = self._registers[address : address + count]
        return registers if self.is_healthy else self._nonsense(registers)

    def close(self) -> None:
        """Nothing to give back."""

    def _nonsense(self, registers: list[int]) -> Sequence[int]:
        chance = self._random
        kind = chance.random()
        if kind < 0.02:
            raise ModbusReadError("no valid answer in time", answered=False)
        if kind < 0.1:
            raise ModbusReadError(f"exception {chance.randrange(256)}", answered=True)
        if kind < 0.2:
            return [chance.randrange(65536) for _ in range(chance.randrange(130))]
        if kind < 0.25:
            return [chance.randrange(-70000, 140000) for _ in registers]
        if kind < 0.6:
            return [self._wrong() if chance.random() < 0.1 else word for word in registers]
        return [chance.randrange(65536) for _ in registers]

    def _wrong(self) -> int:
        """Also the first words of infinities and of what is no number."""
        return self._random.choice((self._random.randrange(65536), 0x7F80, 0xFF80, 0x7FC0))


def fuzz(directory: Path, answers: int) -> None:
    loaded = unproven()
    connection = Answers(loaded.rig, seed=5)
    valves: list[SimpleDevice] = []

    def create(name: str, device: Device, rig: Rig, lockstep: bool) -> Driver:
        if name == GAUGES:
            return ModbusDriver(name, device_options(name, device), lambda options: connection)
        made = SimpleDevice(name, device, rig, lockstep)
        valves.extend([made] if made.outputs else [])
        return made

    seen: set[Mode] = set()
    with LockstepRig(loaded, directory, create=create) as rig:
        values = [rig.facts.index(name) for name in rig.facts.names if name.endswith(("_pressure_Pa", "_temperature_C", ".position"))]
        while connection.given < answers:
            connection.is_healthy = True
            rig.cycles(20)  # the driver's pause after a failure is over
            rig.arm()
            assert rig.mode is Mode.HOLDING
            connection.is_healthy = False
            end = connection.given + EPISODE
            while connection.given < min(end, answers):
                rig.cycles(1)
                seen.add(rig.mode)
                assert all(not abs(rig.loop.values[index]) > 1e40 for index in values)
                assert all(valve.written is None for valve in valves) == (rig.mode is not Mode.HOLDING)
                if connection.given % 50 == 0:
                    rig.post(OperatorAction.RESET)
            rig.post(OperatorAction.RESET)
            rig.cycles(2)
        assert all(abs(valve.positions[valve.joints[0]] - before) < 0.01 for valve, before in zip(valves, (0.0, 0.9144), strict=True))
        assert all(isfinite(valve.positions[valve.joints[0]]) for valve in valves)
    assert {Mode.FAULT, Mode.DISARMED} <= seen <= {Mode.FAULT, Mode.DISARMED, Mode.HOLDING}


def test_two_thousand_answers(tmp_path: Path) -> None:
    fuzz(tmp_path, 2_000)


@pytest.mark.slow
def test_a_hundred_thousand_answers(tmp_path: Path) -> None:
    fuzz(tmp_path, 100_000)
