"""One device that is read again and again: the objects of a CANopen node by SDO, or the registers of a Modbus unit. Reads only."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

import can

from config.errors import DriverError
from config.options.canopen_options import CanBus
from config.options.modbus_options import RtuOptions, TcpOptions
from drivers.canopen.bus import open_can
from drivers.canopen.node_reader import NodeReader
from drivers.contract import Quality
from drivers.inspection.can_traffic import Traffic, listen
from drivers.inspection.modbus_scan import refuse_used
from drivers.inspection.objects import NodeObject
from drivers.link_claim import LinkClaim
from drivers.modbus import ModbusDriver

LISTEN_S = 0.25  # a loop that runs sends SYNC every cycle


class Source(Protocol):
    """What `read` and `watch` ask."""

    def read(self) -> list[float | str | None]:
        """One value a place, in their order; None where the device did not give one."""

    def problems(self) -> list[str]:
        """Why, for the places of the last read() that have none."""


@contextmanager
def can_to_ask(bus: CanBus) -> Iterator[can.BusABC]:
    """The bus, ours alone on this machine. DriverError when it cannot be opened, or when a master speaks there."""
    claim = LinkClaim(bus.link)
    try:
        can_bus = open_can(bus)
        try:
            traffic = Traffic()
            listen(can_bus, traffic, LISTEN_S)
            if traffic.masters:
                advice = "Two masters would take each other's answers: ask through that master, or end it first."
                value = ", ".join(sorted(traffic.masters))
                raise DriverError("a master speaks on this bus", value=value, where=bus.channel, next_step=advice)
            yield can_bus
        finally:
            can_bus.shutdown()
    finally:
        claim.release()


class NodeSource:
    """Objects of one node. Use `can_to_ask` for the bus."""

    def __init__(self, reader: NodeReader, objects: Sequence[NodeObject]) -> None:
        self._reader = reader
        self._objects = objects
        self._problems: list[str] = []

    def read(self) -> list[float | str | None]:
        self._problems = []
        return [self._value(each) for each in self._objects]

    def problems(self) -> list[str]:
        return self._problems

    def _value(self, wanted: NodeObject) -> float | str | None:
        try:
            return wanted.value(self._reader.upload(wanted.index, wanted.sub))
        except DriverError as refusal:
            self._problems.append(str(refusal))
            return None


class UnitSource:
    """Registers of one Modbus unit, through the driver that the daemon uses."""

    def __init__(self, options: TcpOptions | RtuOptions) -> None:
        refuse_used(options)
        self._driver = ModbusDriver("", options)  # it has no name: its messages begin with the address
        self._driver.open()

    def read(self) -> list[float | str | None]:
        samples = self._driver.read(time.monotonic_ns())
        return [None if sample.quality is Quality.BAD else sample.raw for sample in samples]

    def problems(self) -> list[str]:
        return [self._driver.failure] if self._driver.failure else []

    def close(self) -> None:
        self._driver.close()
