"""Options of a Modbus device: how it is reached and which register holds which channel.

The register map stands in the rig file, next to the signals; the driver reads by it and the twin serves by it.
Scale and offset are not here: they are the calibration of the signal, applied to the raw count of the register.
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Annotated, ClassVar, Literal

from pydantic import Field, Tag, field_validator

from config.options.device_options import Address, Channel, DeviceOptions, RigNames
from config.schema.section import Section, chosen_by, quantity

RegisterType = Literal["int16", "uint16", "int32", "uint32", "float32"]
RegisterTable = Literal["input", "holding"]
WordOrder = Literal["big", "little"]

REGISTERS: dict[str, int] = {"int16": 1, "uint16": 1, "int32": 2, "uint32": 2, "float32": 2}
LAST_ADDRESS = 0xFFFF
# What register lists of devices write for address 0: the table's number in front, counted from 1.
_REGISTER_1 = {30001: "input", 40001: "holding"}
_HOST_NAME = re.compile(r"(?=.*[A-Za-z])[A-Za-z0-9_]([A-Za-z0-9_.-]*[A-Za-z0-9_])?\.?")
_LARGEST = {"int16": 2**15 - 1, "uint16": 2**16 - 1, "int32": 2**31 - 1, "uint32": 2**32 - 1}


class ModbusChannel(Section):
    """Where one channel stands in the device's registers."""

    table: RegisterTable = Field(default="input", description="input registers (function 4) or holding registers (function 3)")
    address: int = Field(ge=0, le=LAST_ADDRESS, description="address of the first register, counted from 0 (register 30001 has address 0)")
    type: RegisterType = Field(default="int16", description="how the number is kept; 32 bits take two registers")
    word_order: WordOrder = Field(default="big", description="big: the high word stands in the first register")

    @property
    def end(self) -> int:
        """Address of the first register behind it."""
        return self.address + REGISTERS[self.type]

    def range(self) -> tuple[float | None, float | None]:
        """Smallest and largest raw count; (None, None) for a float."""
        largest = _LARGEST.get(self.type)
        if largest is None:
            return None, None
        return (0.0 if self.type.startswith("u") else -1.0 - largest), float(largest)


class ModbusOptions(DeviceOptions):
    """What TCP and RTU have in common."""

    served_by: ClassVar[Literal["loop", "I/O process", "either"]] = "I/O process"

    unit_id: int = Field(default=1, ge=1, le=247, description="the device's unit (slave) number")
    answer_timeout_s: float = quantity("s", "no answer within this time is a time-out", 0.1, low=0.005, high=5)
    retry_after_s: float = quantity("s", "pause after a time-out or a lost connection before the next try", 0.5, low=0.01, high=60)
    largest_gap: int = Field(default=8, ge=0, le=120, description="registers nobody asked for that are read to join two blocks")
    channels: dict[str, ModbusChannel] = Field(min_length=1, description="every channel by name")

    @field_validator("channels")
    @classmethod
    def _registers_fit(cls, channels: dict[str, ModbusChannel]) -> dict[str, ModbusChannel]:
        for name, channel in channels.items():
            if channel.end - 1 > LAST_ADDRESS:
                raise ValueError(f"{name}: {channel.type} at address {channel.address} ends beyond the last register, {LAST_ADDRESS}")
        ordered = sorted(channels.items(), key=lambda item: (item[1].table, item[1].address))
        for (name, channel), (other, behind) in pairwise(ordered):
            if channel.table == behind.table and behind.address < channel.end:
                shared = f"{channel.type} at {channel.address} and {behind.type} at {behind.address}"
                raise ValueError(f"the channels {name!r} and {other!r} share a register ({shared})")
        return channels

    def input_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        return {name: _channel(where) for name, where in self.channels.items()}

    def warnings(self) -> Iterator[tuple[str, str]]:
        for name, channel in self.channels.items():
            for first, table in _REGISTER_1.items():
                if first <= channel.address < first + 9999:
                    what = f"{name}: address {channel.address} looks like the number of a register. Addresses count from 0:"
                    yield "channels", f"{what} that register has the address {channel.address - first} of the {table} table"


class TcpOptions(ModbusOptions):
    """Modbus TCP."""

    transport: Literal["tcp"] = Field(description="how the device is connected")
    host: str = Field(min_length=1, description="address of the device or its gateway")
    port: int = Field(default=502, ge=1, le=65535, description="TCP port")

    @field_validator("host")
    @classmethod
    def _is_a_host(cls, host: str) -> str:
        """A name or an address alone; whether it is there, only the network knows."""
        if not host or _HOST_NAME.fullmatch(host):
            return host
        try:
            ipaddress.ip_address(host)
        except ValueError as error:
            raise ValueError("neither a host name nor an IP address; the port has a key of its own") from error
        return host

    def address(self) -> Address:
        return Address(("Modbus TCP", self.host, str(self.port)), self.unit_id, "unit_id", alone=False)


class RtuOptions(ModbusOptions):
    """Modbus RTU on a serial line."""

    transport: Literal["rtu"] = Field(description="how the device is connected")
    port: str = Field(min_length=1, description="serial port, for example /dev/ttyUSB0")
    baud_rate: int = Field(default=19200, ge=1200, le=921600, description="bits per second")
    parity: Literal["none", "even", "odd"] = Field(default="even", description="parity of the serial line")
    stop_bits: Literal[1, 2] = Field(default=1, description="stop bits of the serial line")

    def address(self) -> Address:
        line = {"baud_rate": self.baud_rate, "parity": self.parity, "stop_bits": self.stop_bits}
        return Address(("Modbus RTU", self.port), self.unit_id, "unit_id", line, alone=False)


AnyModbusOptions = Annotated[Annotated[TcpOptions, Tag("tcp")] | Annotated[RtuOptions, Tag("rtu")], chosen_by("transport")]


def _channel(where: ModbusChannel) -> Channel:
    low, high = where.range()
    return Channel(f"{where.table} register {where.address}, {where.type}", low=low, high=high)
