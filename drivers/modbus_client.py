"""The one place where pymodbus is called: a connection that answers with registers or raises ModbusReadError, and always in time.

pymodbus would by default try four times for three seconds each; here there is one try, bounded by the answer time-out. After a
time-out the connection is closed, so that a late answer cannot be taken for the answer to the next question. The next question opens it
again.
"""

from __future__ import annotations

import contextlib
import logging
import os
import socket
import threading
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from pymodbus import ModbusException
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.constants import ExcCodes

from config.errors import DriverError
from config.options.modbus_options import RtuOptions, TcpOptions
from drivers.link_claim import LinkClaim, holder, named

_PARITY = {"none": "N", "even": "E", "odd": "O"}

logging.getLogger("pymodbus").setLevel(logging.CRITICAL)  # it prints its last frames at every lost link; the driver reports those itself


class ModbusReadError(DriverError):
    """A request was not answered with registers.

    `answered`: the device itself refused, so that the connection is still good; `code`: with this exception code.
    """

    def __init__(self, reason: str, *, answered: bool, code: int = 0) -> None:
        super().__init__(reason)
        self.answered = answered
        self.code = code


class ModbusConnection(Protocol):
    """What the driver needs of a connection."""

    def connect(self) -> None: ...

    def read(self, table: str, address: int, count: int) -> Sequence[int]: ...

    def close(self) -> None: ...


class _Link:
    """A link and who uses it in this process. The devices of a serial line share its client and take turns; over TCP each has its own."""

    def __init__(self, options: TcpOptions | RtuOptions) -> None:
        self.users = 0
        self.client = _client(options) if isinstance(options, RtuOptions) else None
        self.turn = threading.Lock() if self.client else contextlib.nullcontext()
        self.claim: LinkClaim | None = None
        with contextlib.suppress(DriverError):  # TCP allows it, and a serial port refuses a second process itself
            self.claim = LinkClaim(options.address().link)

    def release(self) -> None:
        if self.claim is not None:
            self.claim.release()


_links: dict[tuple[str, ...], _Link] = {}
_links_lock = threading.Lock()


class PymodbusConnection:
    """A synchronous pymodbus client for TCP or RTU."""

    def __init__(self, options: TcpOptions | RtuOptions) -> None:
        self._options = options
        self._link: _Link | None = None
        self._client: ModbusTcpClient | ModbusSerialClient | None = None

    def connect(self) -> None:
        """Raises ModbusReadError when the device or the serial port does not open within the answer time-out."""
        link = self._acquired()
        try:
            with link.turn:
                connected = bool(self._opened().connect())
        except Exception as error:  # pyserial and sockets have errors of their own
            raise ModbusReadError(f"no connection: {_short(error)}", answered=False) from error
        if not connected:
            process = holder(self._options.address().link)
            by = f": {named(process)} of longreach has it" if process not in (None, os.getpid()) else _not_there(self._options)
            raise ModbusReadError(f"no connection{by}", answered=False)

    def read(self, table: str, address: int, count: int) -> Sequence[int]:
        """`count` registers from `address` on. Raises ModbusReadError; after one with answered=False the connection is closed."""
        client = self._opened()
        ask = client.read_input_registers if table == "input" else client.read_holding_registers
        answer = self._asked(lambda: ask(address, count=count, device_id=self._options.unit_id))
        return list(answer.registers)

    def identification(self) -> str:
        """Maker, product and revision (function 43, 14: basic identification). Raises ModbusReadError as read()."""
        client = self._opened()
        answer = self._asked(lambda: client.read_device_information(read_code=1, object_id=0, device_id=self._options.unit_id))
        return " ".join(text.decode("ascii", "replace") for text in answer.information.values() if isinstance(text, bytes))

    def close(self) -> None:
        """The last one on a serial line closes it."""
        client, link = self._client, self._link
        self._client = self._link = None
        if client is None or link is None:
            return
        with _links_lock:
            link.users -= 1
            if link.users == 0:
                del _links[self._options.address().link]
                link.release()
            if link.users == 0 or client is not link.client:
                client.close()  # type: ignore[no-untyped-call]

    def _asked(self, request: Callable[[], Any]) -> Any:
        """The answer to one request; nobody else asks on this line meanwhile."""
        link, client = self._acquired(), self._opened()
        with link.turn:
            client.comm_params.timeout_connect = self._options.answer_timeout_s
            try:
                answer = request()
            except Exception as error:  # time-outs are ModbusIOException, cut links OSError, garbage struct.error or IndexError
                client.close()  # type: ignore[no-untyped-call]
                reason = "no valid answer in time" if isinstance(error, ModbusException) else _short(error)
                raise ModbusReadError(reason, answered=False) from error
        if answer.isError():
            raise ModbusReadError(f"exception {_code(answer.exception_code)}", answered=True, code=answer.exception_code)
        return answer

    def _acquired(self) -> _Link:
        if self._link is None:
            key = self._options.address().link
            with _links_lock:
                if key not in _links:
                    _links[key] = _Link(self._options)
                self._link = _links[key]
                self._link.users += 1
            self._client = self._link.client or _client(self._options)
        return self._link

    def _opened(self) -> ModbusTcpClient | ModbusSerialClient:
        if self._client is None:
            raise ModbusReadError("the connection is closed", answered=False)
        return self._client


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


def _not_there(options: TcpOptions | RtuOptions) -> str:
    """What the client does not say: a port or a host of that name does not exist."""
    if isinstance(options, RtuOptions):
        return "" if os.path.exists(options.port) else f": there is no {options.port}, `ls /dev/tty*` shows the ports"
    try:
        socket.getaddrinfo(options.host, options.port)
    except OSError as error:
        return f": {options.host}: {error.strerror}"
    return ""
