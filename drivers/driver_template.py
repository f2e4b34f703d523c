"""The files of a plug-in with one driver: package, options with channels, verbs, contract test. `longreach new-driver` writes them."""

from __future__ import annotations

_PYPROJECT = """\
[build-system]
requires = ["setuptools>=68"]
build-backend = "setuptools.build_meta"

[project]
name = "longreach-NAME"
version = "0.1.0"
description = "longreach driver NAME"
dependencies = ["longreach"]

[project.entry-points."longreach.drivers"]
NAME = "longreach_NAME:create"

[project.entry-points."longreach.driver_options"]
NAME = "longreach_NAME:Options"

[tool.setuptools]
py-modules = ["longreach_NAME"]

[tool.pytest.ini_options]
pythonpath = ["."]
"""

_DRIVER = '''\
"""Driver NAME. As written, the device is a Memory in this file: an output that is read back. Put your device in its place."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from math import isfinite, nan
from typing import Any

from pydantic import Field

from config.errors import DriverError
from config.options.device_options import Address, Channel, DeviceOptions, RigNames
from config.options.driver_options import device_options
from config.schema.section import quantity
from drivers.contract import Quality, Sample

LARGEST_V = 10.0


class Options(DeviceOptions):
    """What may stand under `options:`; `longreach check`, --set and `longreach device options NAME` read this class."""

    port: str = Field(default="memory", min_length=1, description="where the device is connected")
    unit: int = Field(default=1, ge=1, le=247, description="the device's number there")
    answer_timeout_s: float = quantity("s", "no answer within this time is a failure", 0.01, low=0.001, high=1)

    def input_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        return {"voltage": Channel("voltage at the terminals", "V", -LARGEST_V, LARGEST_V)}

    def output_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        return {"command": Channel("voltage to the valve", "V", -LARGEST_V, LARGEST_V)}

    def address(self) -> Address:
        return Address(("NAME", self.port), self.unit, "unit")


class Memory:
    """Stands in for the device and its own time-out: without a command for `timeout` its output is 0."""

    def __init__(self, timeout_s: float) -> None:
        self.timeout_ns = round(1e9 * timeout_s)
        self.told_V, self.told_ns = 0.0, 0

    @property
    def output_V(self) -> float:
        return self.told_V if time.monotonic_ns() - self.told_ns <= self.timeout_ns else 0.0


def create(name: str, device: Any, rig: Any, lockstep: bool) -> Driver:
    """The factory that the rig file's `driver: NAME` calls."""
    options = device_options(name, device)
    assert isinstance(options, Options)
    return Driver(name, options, device.timeout_s)


class Driver:
    """open -> configure -> activate -> (read, write)* -> safe -> close: see drivers.contract."""

    def __init__(self, name: str, options: Options, timeout_s: float) -> None:
        self.name = name
        self.inputs = tuple(options.input_channels(RigNames()))
        self.outputs = tuple(options.output_channels(RigNames()))
        self.device: Memory | None = None
        self._options = options
        self._timeout_s = timeout_s
        self._active = False
        self._samples = [Sample() for _ in self.inputs]

    def open(self) -> None:
        self.device = Memory(self._timeout_s)

    def configure(self) -> None:
        """Write the device's settings, read them back, raise DriverError on a difference."""
        self._opened()

    def activate(self) -> None:
        self._opened().told_V = 0.0
        self._active = True

    def read(self, now_ns: int) -> Sequence[Sample]:
        volts = self._opened().output_V
        for sample in self._samples:
            sample.raw, sample.stamp_ns = (volts, now_ns) if isfinite(volts) else (nan, sample.stamp_ns)
            sample.quality = Quality.GOOD if isfinite(volts) else Quality.BAD
        return self._samples

    def write(self, values: Sequence[float], now_ns: int) -> None:
        device = self._opened()
        if not self._active:
            raise DriverError("the device is not active", where=self.name, next_step="Call activate() before write().")
        if len(values) != len(self.outputs):
            self.safe()
            raise DriverError("wrong number of outputs", value=len(values), limit=len(self.outputs), where=self.name)
        if not all(map(isfinite, values)):
            self.safe()
            raise DriverError("an output is not a finite number", value=list(values), where=self.name)
        device.told_V, device.told_ns = values[0], time.monotonic_ns()

    def safe(self) -> None:
        self._active = False
        if self.device is not None:
            self.device.told_V = 0.0

    def close(self) -> None:
        self.safe()
        self.device = None

    def _opened(self) -> Memory:
        if self.device is None:
            raise DriverError("the device is not open", where=self.name, next_step="Call open() first.")
        return self.device
'''

_TEST = '''\
"""The driver contract, with driver NAME. `pytest` runs it wherever longreach is installed."""

from __future__ import annotations

from longreach_NAME import Driver, Memory, Options

from drivers.driver_contract import OutputContract, Outputs


class TestDriver(OutputContract):
    safe_outputs = (0.0,)
    device: Memory | None = None

    def make(self) -> Driver:
        return Driver("device", Options(), timeout_s=1.0)

    def actual_outputs(self, driver: Driver) -> Outputs:
        """What the device does, seen past the driver, also after the driver has given it back."""
        self.device = driver.device or self.device
        return (self.device.output_V if self.device else 0.0,)
'''


def driver_files(name: str) -> dict[str, str]:
    """File name -> text of the package of driver `name`."""
    files = {"pyproject.toml": _PYPROJECT, f"longreach_{name}.py": _DRIVER, f"test_{name}.py": _TEST}
    return {file: text.replace("NAME", name) for file, text in files.items()}
