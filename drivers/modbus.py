"""Modbus analog inputs (pressure, temperature, ...) over TCP or RTU: a slow device, polled by the I/O process and never in the loop.

A read asks for all blocks, one after the other, and takes at most the answer time-out for each. A channel is BAD while its block is
not answered with registers: exception code, time-out, wrong length, lost connection. After a failure without an answer the device
is left alone for `retry_after`; until then a read costs nothing and every channel is BAD.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from math import isfinite, nan

from config.errors import ConfigError, DriverError
from config.options.device_options import RigNames
from config.options.driver_options import device_options
from config.options.modbus_options import RtuOptions, TcpOptions
from config.schema.rig import Device, Rig
from drivers.contract import Driver, Quality, Sample
from drivers.modbus_client import ModbusConnection, ModbusReadError, PymodbusConnection
from drivers.modbus_registers import Block, blocks

Connect = Callable[[TcpOptions | RtuOptions], ModbusConnection]


def create(name: str, device: Device, rig: Rig, lockstep: bool) -> Driver:
    """The driver factory. Raises ConfigError for options that cannot be used."""
    if lockstep:
        raise DriverError("a Modbus device lives in real time", where=f"devices.{name}", next_step="Use the wall clock, or driver: sim.")
    if not device.slow:
        advice = "A Modbus answer takes longer than a cycle of the loop: write slow: true."
        raise ConfigError("a Modbus device must be slow", value="slow: false", where=f"devices.{name}.slow", next_step=advice)
    options = device_options(name, device)
    assert isinstance(options, (TcpOptions, RtuOptions))
    return ModbusDriver(name, options)


class ModbusDriver:
    """One Modbus device. `failure` says why the last read did not succeed (empty when it did); `failures` counts such reads."""

    def __init__(self, name: str, options: TcpOptions | RtuOptions, connect: Connect = PymodbusConnection) -> None:
        self.name = name
        self.inputs: tuple[str, ...] = tuple(options.input_channels(RigNames()))
        self.outputs: tuple[str, ...] = ()
        self.failure = ""
        self.failures = 0
        self._options = options
        self._connect = connect
        self._blocks = blocks(options.channels, options.largest_gap)
        self._samples = [Sample() for _ in self.inputs]
        self._connection: ModbusConnection | None = None
        self._is_connected = False
        self._next_try_ns: int | None = None

    def open(self) -> None:
        """Connects. Raises DriverError when the device is not there."""
        if self._connection is not None:
            raise DriverError("the device is open already", where=self.name)
        connection = self._connect(self._options)
        try:
            connection.connect()
        except ModbusReadError as failure:
            connection.close()
            raise self._no_answer(failure) from failure
        self._connection = connection
        self._is_connected = True

    def configure(self) -> None:
        """Reads every block once: a wrong address, type or unit number shows here and not in the first cycle."""
        connection = self._opened()
        for block in self._blocks:
            try:
                block.raw_counts(connection.read(block.table, block.address, block.count))
            except (ModbusReadError, ValueError) as failure:
                raise self._refused(block, failure) from failure

    def activate(self) -> None:
        """Nothing to do: there are no outputs."""
        self._opened()

    def read(self, now_ns: int) -> Sequence[Sample]:
        """Polls the device. The stamp is the time of asking, so an age is never understated."""
        connection = self._opened()
        if self._next_try_ns is not None and now_ns < self._next_try_ns:
            return self._samples  # all BAD since the failure
        began_ns = time.monotonic_ns()
        try:
            self._poll(connection, now_ns)
        except ModbusReadError as failure:
            self._lost(str(failure), now_ns + time.monotonic_ns() - began_ns)
        return self._samples

    def write(self, values: Sequence[float], now_ns: int) -> None:
        if len(values) > 0:
            raise DriverError("a Modbus device has no outputs", value=len(values), limit=0, where=self.name)

    def safe(self) -> None:
        """There are no outputs: always safe."""

    def close(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        self._all_bad()

    def _poll(self, connection: ModbusConnection, now_ns: int) -> None:
        if not self._is_connected:
            connection.connect()
            self._is_connected = True
        failures = [failure for block in self._blocks if (failure := self._read_block(connection, block, now_ns))]
        self._next_try_ns = None
        self.failure = "; ".join(failures)
        self.failures += bool(failures)

    def _read_block(self, connection: ModbusConnection, block: Block, now_ns: int) -> str:
        """Fills the samples of one block; returns why the device refused, if it did. Raises ModbusReadError when it did not answer."""
        try:
            counts = block.raw_counts(connection.read(block.table, block.address, block.count))
        except (ModbusReadError, ValueError) as failure:
            if isinstance(failure, ModbusReadError) and not failure.answered:
                raise
            for place in block.places:
                _mark_bad(self._samples[place.channel])
            return f"{block.table} {block.address}: {failure}"
        for channel, raw in counts:
            sample = self._samples[channel]
            sample.raw = raw if isfinite(raw) else nan
            sample.stamp_ns = now_ns
            sample.quality = Quality.GOOD if isfinite(raw) else Quality.BAD
        return ""

    def _lost(self, reason: str, ended_ns: int) -> None:
        self._is_connected = False
        self._next_try_ns = ended_ns + round(1e9 * self._options.retry_after_s)
        self.failure = reason
        self.failures += 1
        self._all_bad()

    def _all_bad(self) -> None:
        for sample in self._samples:
            _mark_bad(sample)

    def _opened(self) -> ModbusConnection:
        if self._connection is None:
            raise DriverError("the device is not open", where=self.name, next_step="Call open() first.")
        return self._connection

    def _no_answer(self, failure: ModbusReadError) -> DriverError:
        advice = f"Check cable, power and address; `longreach device scan {_where(self._options)}` shows who answers there."
        return DriverError(f"{_address(self._options)} cannot be reached", value=str(failure), where=self.name, next_step=advice)

    def _refused(self, block: Block, failure: Exception) -> DriverError:
        what = f"{block.table} registers {block.address} to {block.address + block.count - 1} of {_address(self._options)} cannot be read"
        advice = f"Compare devices.{self.name}.options with the device's register list (addresses count from 0)."
        return DriverError(what, value=str(failure), where=self.name, next_step=advice)


def _mark_bad(sample: Sample) -> None:
    """No value; the stamp stays that of the last good value, so that the age goes on growing."""
    sample.raw = nan
    sample.quality = Quality.BAD


def _where(options: TcpOptions | RtuOptions) -> str:
    """As the device commands have it."""
    return f"tcp:{options.host}:{options.port}" if isinstance(options, TcpOptions) else f"rtu:{options.port}"


def _address(options: TcpOptions | RtuOptions) -> str:
    place = f"{options.host}:{options.port}" if isinstance(options, TcpOptions) else options.port
    return f"{place}, unit {options.unit_id}"
