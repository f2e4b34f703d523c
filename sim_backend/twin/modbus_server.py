"""The Modbus TCP servers of the twin: pymodbus' server in a thread of its own, one listener for every address in the rig file."""

from __future__ import annotations

import asyncio
import logging
import threading
from typing import Any

from pymodbus.server import ModbusTcpServer

from config.errors import ConfigError, PlantError
from config.modbus_options import TcpOptions, modbus_options
from config.rig import Rig
from sim_backend.twin.modbus_unit import ModbusUnit

_WATCH_S = 0.02
_START_LIMIT_S = 10.0


def modbus_units(rig: Rig) -> dict[tuple[str, int], list[ModbusUnit]]:
    """Address → units of the rig that answer there. ConfigError for a unit on a serial line, which the twin cannot serve."""
    units: dict[tuple[str, int], list[ModbusUnit]] = {}
    for name, device in rig.devices.items():
        if device.driver != "modbus":
            continue
        options = modbus_options(name, device)
        if not isinstance(options, TcpOptions):
            advice = "Use transport: tcp in the rig file of the simulation."
            raise ConfigError("the twin serves Modbus over TCP only", value="rtu", where=f"devices.{name}.options", next_step=advice)
        signals = {signal.channel: signal_name for signal_name, signal in rig.signals.items() if signal.device == name}
        units.setdefault((options.host, options.port), []).append(ModbusUnit(name, options, signals))
    return units


class ModbusServers:
    """All Modbus servers of a twin. `start` returns when they listen; `close` when they are gone."""

    def __init__(self, units: dict[tuple[str, int], list[ModbusUnit]]) -> None:
        self._units = units
        self._stop = threading.Event()
        self._listening = threading.Event()
        self._error = ""
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve()), name="modbus", daemon=True)

    def start(self) -> None:
        """Raises PlantError when an address cannot be used."""
        logging.getLogger("pymodbus").setLevel(logging.CRITICAL)
        self._thread.start()
        if not self._listening.wait(_START_LIMIT_S) or self._error:
            self.close()
            named = ", ".join(f"{host}:{port}" for host, port in self._units)
            raise PlantError(
                "the Modbus server cannot listen", value=self._error, where=named, next_step="Is the port in use, or below 1024?"
            )

    def close(self) -> None:
        self._stop.set()
        self._thread.join(_START_LIMIT_S)

    async def _serve(self) -> None:
        watches = [asyncio.create_task(self._watch(address, units)) for address, units in self._units.items()]
        done, _ = await asyncio.wait(watches, return_when=asyncio.FIRST_EXCEPTION)
        self._error = "; ".join(str(task.exception()) for task in done if task.exception())
        self._listening.set()

    async def _watch(self, address: tuple[str, int], units: list[ModbusUnit]) -> None:
        """Keep the server up, except while one of its units is dead: the listener then goes away and connections are cut."""
        server: Any = None
        while not self._stop.is_set():
            is_dead = any(unit.is_dead for unit in units)
            if server is None and not is_dead:
                server = ModbusTcpServer([unit.device() for unit in units], address=address)
                await server.serve_forever(background=True)
                self._listening.set()
            elif server is not None and is_dead:
                await server.shutdown()
                server = None
            await asyncio.sleep(_WATCH_S)
        if server is not None:
            await server.shutdown()
