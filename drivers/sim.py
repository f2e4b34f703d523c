"""The simulated rig behind the driver contract: the plant of the rig file, sensors in raw counts, valves with their own time-out.

Lockstep: the plant moves exactly one period in each read. Wall clock: it moves by the whole periods that have passed since the last
read, rounded, so that a late cycle meets a plant that has moved on and a few microseconds of jitter change nothing.
The plant obeys the output register and not the caller, so the device's time-out works as on a real valve amplifier.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

from config.errors import DriverError
from config.options.driver_options import device_options, rig_names
from config.options.sim_options import SimOptions
from config.schema.rig import Device, Rig
from drivers.contract import Driver, Quality, Sample
from drivers.output_register import OutputRegister
from sim_backend.plant import SimulatedRig

LONGEST_CATCH_UP_S = 1.0  # a process that was stopped for longer finds the plant only this much later


def create(name: str, device: Device, rig: Rig, lockstep: bool) -> Driver:
    """The driver factory. With $RUNTIME_DIRECTORY the register of outputs is a file there, which other processes may watch."""
    directory = os.environ.get("RUNTIME_DIRECTORY")
    path = None if lockstep or not directory else Path(directory) / f"{name}.outputs"
    return SimDriver(name, device, rig, lockstep, path)


class SimDriver:
    """One simulated device that carries every sensor and every valve of the rig."""

    def __init__(self, name: str, device: Device, rig: Rig, lockstep: bool, register_path: Path | None = None) -> None:
        self.name = name
        self._rig = rig
        self._lockstep = lockstep
        self._timeout_s = device.timeout_s
        self._register_path = register_path
        self._period_s = 1.0 / rig.loop.rate_Hz
        self._period_ns = round(1e9 * self._period_s)
        self._most_periods = round(LONGEST_CATCH_UP_S / self._period_s)
        options = device_options(name, device)
        assert isinstance(options, SimOptions)
        self._plant = SimulatedRig(rig, seed=options.seed)
        self.inputs: tuple[str, ...] = tuple(options.input_channels(rig_names(rig)))
        self.outputs: tuple[str, ...] = tuple(options.output_channels(rig_names(rig)))
        self._samples = [Sample() for _ in self.inputs]
        self._register: OutputRegister | None = None
        self._plant_ns: int | None = None
        self._active = False

    def open(self) -> None:
        """Builds the plant's compiled code, so that no cycle pays for it."""
        if self._register is not None:
            raise DriverError("the device is open already", where=self.name)
        safe = [0.0] * len(self.outputs)
        self._plant.advance(safe, self._period_s)
        self._plant.sense()
        self._plant.reset()
        self._register = OutputRegister.create(safe, self._timeout_s, self._register_path)

    def configure(self) -> None:
        """Nothing to set; the read-back is that of the time-out."""
        written = self._opened().timeout_s
        if abs(written - self._timeout_s) > 1e-9:
            raise DriverError("the time-out read back differs", value=written, limit=self._timeout_s, unit="s", where=self.name)

    def activate(self) -> None:
        self._opened().make_safe()
        self._active = True

    def read(self, now_ns: int) -> Sequence[Sample]:
        register = self._opened()
        self._advance(register, now_ns)
        for sample, raw in zip(self._samples, self._plant.sense(), strict=True):
            sample.raw = raw
            sample.stamp_ns = now_ns
            sample.quality = Quality.GOOD if raw == raw else Quality.BAD  # NaN: a drop-out
        return self._samples

    def write(self, values: Sequence[float], now_ns: int) -> None:
        register = self._opened()
        if not self._active:
            raise DriverError("the device is not active", where=self.name, next_step="Call activate() before write().")
        if len(values) != len(self.outputs):
            register.make_safe()
            raise DriverError("wrong number of outputs", value=len(values), limit=len(self.outputs), where=self.name)
        for value in values:
            if not isfinite(value):
                register.make_safe()
                raise DriverError(
                    "an output is not a finite number", value=value, unit="V", where=self.name, next_step="Outputs are safe now."
                )
        register.write(values, now_ns)

    def safe(self) -> None:
        """May be called at any time, also before open and after close, when the outputs are safe anyway."""
        self._active = False
        if self._register is not None:
            self._register.make_safe()

    def close(self) -> None:
        self.safe()
        if self._register is not None:
            self._register.close()
            self._register = None

    def _advance(self, register: OutputRegister, now_ns: int) -> None:
        if self._plant_ns is None:
            self._plant_ns = now_ns if not self._lockstep else now_ns - self._period_ns
        periods = 1 if self._lockstep else round((now_ns - self._plant_ns) / self._period_ns)
        if periods > self._most_periods:
            self._plant_ns += (periods - self._most_periods) * self._period_ns
            periods = self._most_periods
        for _ in range(periods):
            self._plant.advance(register.effective(self._plant_ns), self._period_s)
            self._plant_ns += self._period_ns

    def _opened(self) -> OutputRegister:
        if self._register is None:
            raise DriverError("the device is not open", where=self.name, next_step="Call open() first.")
        return self._register
