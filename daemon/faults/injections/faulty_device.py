"""The simulated rig's device with faults: samples changed on their way to the loop, methods that raise or take long."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from config.schema.rig import Device, Rig
from drivers.contract import Sample
from drivers.sim import SimDriver
from sim_backend.memory.layout import C, X

Tamper = Callable[[Sample, int], None]  # the sample as it was taken, and now_ns


class FaultyDevice(SimDriver):
    """`tamper[channel]` changes a sample in each read; `before[verb]` runs first in that method; `disconnected` outputs stay 0."""

    def __init__(self, name: str, device: Device, rig: Rig, register_path: Path) -> None:
        super().__init__(name, device, rig, lockstep=False, register_path=register_path)  # a stalled loop finds a plant that moved on
        self.tamper: dict[str, Tamper] = {}
        self.before: dict[str, Callable[[], None]] = {}
        self.disconnected: set[str] = set()

    def lose_supply(self) -> None:
        """Pump and relief valve at no pressure."""
        values = self._plant.parameters.values
        values[[C.SUPPLY_PRESSURE, C.RELIEF_PRESSURE]] = 0.0
        self._plant.state[X.SUPPLY_PRESSURE] = 0.0

    def read(self, now_ns: int) -> Sequence[Sample]:
        self._first("read")
        samples = super().read(now_ns)
        for channel, change in self.tamper.items():
            change(samples[self.inputs.index(channel)], now_ns)
        return samples

    def write(self, values: Sequence[float], now_ns: int) -> None:
        self._first("write")
        super().write([0.0 if name in self.disconnected else value for name, value in zip(self.outputs, values, strict=True)], now_ns)

    def safe(self) -> None:
        self._first("safe")
        super().safe()

    def _first(self, verb: str) -> None:
        if verb in self.before:
            self.before[verb]()
