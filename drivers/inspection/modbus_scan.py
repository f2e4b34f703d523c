"""Which Modbus units answer at an address or on a serial line: one register is read, nothing is ever written.

A unit is there when it answers, with registers or with a refusal of its own; a gateway that says that nobody is behind it (exceptions 10
and 11) is no unit. Some servers say "device failure" (4) of units they do not have: a unit that says nothing else is reported as doubtful.
A port that accepts no connection is not asked again.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from config.errors import DriverError
from config.options.modbus_options import RtuOptions, TcpOptions
from drivers.link_claim import holder, named
from drivers.modbus_client import ModbusReadError, PymodbusConnection

_NOBODY = (10, 11)  # gateway path unavailable; gateway target device failed to respond
_FAILURE = 4
_TABLES = ("input", "holding")


@dataclass(frozen=True, slots=True)
class FoundUnit:
    """`tables`: what register 0 of each table said. `identification`: of the few devices that give it."""

    options: TcpOptions | RtuOptions
    tables: dict[str, str]
    identification: str


@dataclass(frozen=True, slots=True)
class LinkScan:
    """What one address or one setting of the line showed. `problem`: why nothing could be asked there; `asked`: whether it was tried."""

    options: TcpOptions | RtuOptions
    problem: str
    units: tuple[FoundUnit, ...]
    doubtful: tuple[int, ...] = ()
    asked: bool = True


def scan_units(tried: Iterable[TcpOptions | RtuOptions], units: Sequence[int], progress: Callable[[str], None]) -> Iterator[LinkScan]:
    """One result for each of `tried`, whose unit numbers do not count."""
    for options in tried:
        process = holder(options.address().link)
        if process is not None:
            yield LinkScan(options, f"{named(process)} of longreach asks the devices there: not asked", (), asked=False)
            continue
        progress(f"{place(options)}: units {units[0]} to {units[-1]}")
        yield _scan(options, units)


def refuse_used(options: TcpOptions | RtuOptions) -> None:
    """DriverError when another process of longreach asks there: Modbus has no way to listen only."""
    process = holder(options.address().link)
    if process is not None:
        advice = (
            "`longreach status --watch` shows what its daemon reads; stop it (`systemctl stop longreachd`) to ask the devices yourself."
        )
        raise DriverError("a daemon asks the devices there", value=named(process), where=place(options), next_step=advice)


def place(options: TcpOptions | RtuOptions) -> str:
    """The address or the line with its settings, without the unit."""
    if isinstance(options, TcpOptions):
        return f"{options.host}:{options.port}"
    return f"{options.port} {options.baud_rate} baud, parity {options.parity}, {options.stop_bits} stop bits"


def _scan(options: TcpOptions | RtuOptions, units: Sequence[int]) -> LinkScan:
    found: list[FoundUnit] = []
    doubtful: list[int] = []
    for unit in units:
        own = options.model_copy(update={"unit_id": unit})
        connection = PymodbusConnection(own)
        try:
            connection.connect()
            tables, codes = _asked(connection)
            if codes and set(codes) == {_FAILURE}:
                doubtful.append(unit)
            elif tables:
                found.append(FoundUnit(own, tables, _identification(connection)))
        except ModbusReadError as failure:
            return LinkScan(options, str(failure), tuple(found), tuple(doubtful))
        finally:
            connection.close()
    return LinkScan(options, "", tuple(found), tuple(doubtful))


def _asked(connection: PymodbusConnection) -> tuple[dict[str, str], list[int]]:
    """Table → what register 0 holds or why it is refused, and the exception codes (0: none); empty when nobody answers."""
    said: dict[str, str] = {}
    codes: list[int] = []
    for table in _TABLES:
        try:
            said[table], code = " ".join(map(str, connection.read(table, 0, 1))), 0
        except ModbusReadError as failure:
            if not failure.answered or failure.code in _NOBODY:
                continue
            said[table], code = str(failure), failure.code
        codes.append(code)
    return said, codes


def _identification(connection: PymodbusConnection) -> str:
    with contextlib.suppress(ModbusReadError):
        return connection.identification()
    return ""
