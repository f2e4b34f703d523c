"""Options of a Modbus device: how it is reached and which register holds which channel.

The register map stands in the rig file, next to the signals; the driver reads by it and the twin serves by it.
Scale and offset are not here: they are the calibration of the signal, applied to the raw count of the register.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, Tag, field_validator

from config.device_options import options_as
from config.rig import Device
from config.section import Section, chosen_by, quantity

RegisterType = Literal["int16", "uint16", "int32", "uint32", "float32"]
Table = Literal["input", "holding"]
WordOrder = Literal["big", "little"]

REGISTERS: dict[str, int] = {"int16": 1, "uint16": 1, "int32": 2, "uint32": 2, "float32": 2}
LAST_ADDRESS = 0xFFFF


class ModbusChannel(Section):
    """Where one channel stands in the device's registers."""

    table: Table = Field(default="input", description="input registers (function 4) or holding registers (function 3)")
    address: int = Field(ge=0, le=LAST_ADDRESS, description="address of the first register, counted from 0 (register 30001 has address 0)")
    type: RegisterType = Field(default="int16", description="how the number is kept; 32 bits take two registers")
    word_order: WordOrder = Field(default="big", description="big: the high word stands in the first register")


class ModbusOptions(Section):
    """What TCP and RTU have in common."""

    unit_id: int = Field(default=1, ge=1, le=247, description="the device's unit (slave) number")
    answer_timeout_s: float = quantity("s", "no answer within this time is a time-out", 0.1, low=0.005, high=5)
    retry_after_s: float = quantity("s", "pause after a time-out or a lost connection before the next try", 0.5, low=0.01, high=60)
    largest_gap: int = Field(default=8, ge=0, le=120, description="registers nobody asked for that are read to join two blocks")
    channels: dict[str, ModbusChannel] = Field(min_length=1, description="every channel by name")

    @field_validator("channels")
    @classmethod
    def _inside_the_table(cls, channels: dict[str, ModbusChannel]) -> dict[str, ModbusChannel]:
        for name, channel in channels.items():
            last = channel.address + REGISTERS[channel.type] - 1
            if last > LAST_ADDRESS:
                raise ValueError(f"{name}: {channel.type} at address {channel.address} ends beyond the last register, {LAST_ADDRESS}")
        return channels


class TcpOptions(ModbusOptions):
    """Modbus TCP."""

    transport: Literal["tcp"] = Field(description="how the device is connected")
    host: str = Field(description="address of the device or its gateway")
    port: int = Field(default=502, ge=1, le=65535, description="TCP port")


class RtuOptions(ModbusOptions):
    """Modbus RTU on a serial line."""

    transport: Literal["rtu"] = Field(description="how the device is connected")
    port: str = Field(description="serial port, for example /dev/ttyUSB0")
    baud_rate: int = Field(default=19200, ge=1200, le=921600, description="bits per second")
    parity: Literal["none", "even", "odd"] = Field(default="even", description="parity of the serial line")
    stop_bits: Literal[1, 2] = Field(default=1, description="stop bits of the serial line")


AnyModbusOptions = Annotated[Annotated[TcpOptions, Tag("tcp")] | Annotated[RtuOptions, Tag("rtu")], chosen_by("transport")]


def modbus_options(name: str, device: Device) -> TcpOptions | RtuOptions:
    """The options of the Modbus device `name`; ConfigError with every problem."""
    options: Any = options_as(AnyModbusOptions, name, device)
    assert isinstance(options, (TcpOptions, RtuOptions))
    return options
