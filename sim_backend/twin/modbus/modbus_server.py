"""The Modbus servers of the twin: pymodbus' server in a thread of its own, one for every TCP address and every serial line."""

from __future__ import annotations

import asyncio
import logging
import threading
from typing import Any

from pymodbus.server import ModbusSerialServer, ModbusTcpServer

from config.errors import PlantError
from config.options.driver_options import rig_options
from config.options.modbus_options import RtuOptions, TcpOptions
from config.schema.rig import Rig
from sim_backend.twin.modbus.modbus_unit import ModbusUnit
from sim_backend.twin.modbus.serial_line import SerialLine

Link = tuple[str, int] | str  # host and port, or a serial port
_WATCH_S = 0.02
_START_LIMIT_S = 10.0


def modbus_units(rig: Rig) -> dict[Link, list[ModbusUnit]]:
    """Link of the rig file (host and port, or a serial port) → units that answer there."""
    units: dict[Link, list[ModbusUnit]] = {}
    for name, options in rig_options(rig).items():
        if isinstance(options, (TcpOptions, RtuOptions)):
            signals = {signal.channel: signal_name for signal_name, signal in rig.signals.items() if signal.device == name}
            place = (options.host, options.port) if isinstance(options, TcpOptions) else options.port
            units.setdefault(place, []).append(ModbusUnit(name, options, signals))
    return units


class ModbusServers:
    """All Modbus servers of a twin. `start` returns when they listen; `close` when they are gone."""

    def __init__(self, units: dict[Link, list[ModbusUnit]]) -> None:
        self._units = units
        self._lines: dict[Link, SerialLine] = {}
        self._stop = threading.Event()
        self._listening = threading.Event()
        self._error = ""
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve()), name="modbus", daemon=True)

    def start(self) -> None:
        """Raises PlantError when an address cannot be used."""
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)
        self._lines = {place: SerialLine(place) for place in self._units if isinstance(place, str)}
        self._thread.start()
        if not self._listening.wait(_START_LIMIT_S) or self._error:
            self.close()
            named = ", ".join(place if isinstance(place, str) else f"{place[0]}:{place[1]}" for place in self._units)
            raise PlantError(
                "the Modbus server cannot listen", value=self._error, where=named, next_step="Is the port in use, or below 1024?"
            )

    def close(self) -> None:
        self._stop.set()
        self._thread.join(_START_LIMIT_S)
        for line in self._lines.values():
            line.close()

    async def _serve(self) -> None:
        watches = [asyncio.create_task(self._watch(place, units)) for place, units in self._units.items()]
        done, _ = await asyncio.wait(watches, return_when=asyncio.FIRST_EXCEPTION)
        self._error = "; ".join(str(task.exception()) for task in done if task.exception())
        self._listening.set()

    def _server(self, place: Link, units: list[ModbusUnit]) -> Any:
        devices = [unit.device() for unit in units]
        if isinstance(place, str):  # on a line, who is not asked stays silent
            return ModbusSerialServer(devices, port=self._lines[place].server_port, ignore_missing_devices=True)
        return ModbusTcpServer(devices, address=place)

    async def _watch(self, place: Link, units: list[ModbusUnit]) -> None:
        """Keep the server up, except while one of its units is dead: the listener then goes away and connections are cut."""
        server: Any = None
        while not self._stop.is_set():
            is_dead = any(unit.is_dead for unit in units)
            if server is None and not is_dead:
                server = self._server(place, units)
                await server.serve_forever(background=True)
                self._listening.set()
            elif server is not None and is_dead:
                await server.shutdown()
                server = None
            await asyncio.sleep(_WATCH_S)
        if server is not None:
            await server.shutdown()
