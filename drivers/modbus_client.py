"""The one place where pymodbus is called: a connection that answers with registers or raises ModbusReadError, and always in time.

pymodbus would by default try four times for three seconds each; here there is one try, bounded by the answer time-out. After a
time-out the connection is closed, so that a late answer cannot be taken for the answer to the next question.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Protocol

from pymodbus import ModbusException
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.constants import ExcCodes

from config.errors import DriverError
from config.modbus_options import RtuOptions, TcpOptions

_PARITY = {"none": "N", "even": "E", "odd": "O"}

logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # it prints its last frames at every lost link; the driver reports those itself


class ModbusReadError(DriverError):
    """A request was not answered with registers. `answered`: the device itself refused, so that the connection is still good."""

    def __init__(self, reason: str, *, answered: bool) -> None:
        super().__init__(reason)
        self.answered = answered


class ModbusConnection(Protocol):
    """What the driver needs of a connection."""

    def connect(self) -> None: ...

    def read(self, table: str, address: int, count: int) -> Sequence[int]: ...

    def close(self) -> None: ...


class PymodbusConnection:
    """A synchronous pymodbus client for TCP or RTU."""

    def __init__(self, options: TcpOptions | RtuOptions) -> None:
        self._unit_id = options.unit_id
        self._client = _client(options)

    def connect(self) -> None:
        """Raises ModbusReadError when the device or the serial port does not open within the answer time-out."""
        try:
            connected = bool(self._client.connect())
        except Exception as error:  # pyserial and sockets have errors of their own
            raise ModbusReadError(f"no connection: {_short(error)}", answered=False) from error
        if not connected:
            raise ModbusReadError("no connection", answered=False)

    def read(self, table: str, address: int, count: int) -> Sequence[int]:
        """`count` registers from `address` on. Raises ModbusReadError; after one with answered=False the connection is closed."""
        ask = self._client.read_input_registers if table == "input" else self._client.read_holding_registers
        try:
            answer = ask(address, count=count, device_id=self._unit_id)
        except Exception as error:  # time-outs are ModbusIOException, cut links OSError, garbage struct.error or IndexError
            self.close()
            reason = "no valid answer in time" if isinstance(error, ModbusException) else _short(error)
            raise ModbusReadError(reason, answered=False) from error
        if answer.isError():
            raise ModbusReadError(f"exception {_code(answer.exception_code)}", answered=True)
        return list(answer.registers)

    def close(self) -> None:
        self._client.close()  # type: ignore[no-untyped-call]


def _client(options: TcpOptions | RtuOptions) -> ModbusTcpClient | ModbusSerialClient:
    if isinstance(options, TcpOptions):
        return ModbusTcpClient(options.host, port=options.port, timeout=options.answer_timeout_s, retries=0)
    return ModbusSerialClient(
        options.port,
        baudrate=options.baud_rate,
        parity=_PARITY[options.parity],
        stopbits=options.stop_bits,
        timeout=options.answer_timeout_s,
        retries=0,
    )


def _code(code: int) -> str:
    try:
        return f"{code} ({ExcCodes(code).name.lower().replace('_', ' ')})"
    except ValueError:
        return str(code)


def _short(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"[:120]
