"""A Modbus unit for the driver's tests, made of pymodbus' server; its registers are written with pymodbus' own conversion."""

from __future__ import annotations

import asyncio
import socket
import threading
from typing import Any

from pymodbus.client import ModbusTcpClient
from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from config.loading.load import load_rig
from config.schema.rig import Device
from drivers.contract import Driver
from drivers.registry import create

UNIT = 3
_KINDS = ModbusTcpClient.DATATYPE
VALUES: dict[str, tuple[str, int, Any, str, float]] = {
    "pressure": ("input", 0, _KINDS.INT16, "big", -1234),
    "flow": ("input", 1, _KINDS.UINT16, "big", 65000),
    "level": ("input", 4, _KINDS.INT32, "big", -7_000_001),
    "hours": ("input", 6, _KINDS.UINT32, "little", 4_000_000_007),
    "temperature": ("holding", 40, _KINDS.FLOAT32, "big", 61.25),
    "speed": ("holding", 42, _KINDS.FLOAT32, "little", -0.1875),
    "far": ("holding", 300, _KINDS.INT16, "big", 7),
}


class Gauge:
    """`delay_s` before every answer; `exception` instead of one; `is_silent`: never answers; `requests`: (function, address, count)."""

    def __init__(self) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = int(probe.getsockname()[1])
        self.delay_s = 0.0
        self.is_silent = False
        self.exception: ExcCodes | None = None
        self.requests: list[tuple[int, int, int]] = []
        self.registers = {"input": [0] * 16, "holding": [0] * 301}
        for table, address, kind, order, value in VALUES.values():
            number = value if kind is _KINDS.FLOAT32 else int(value)
            words = ModbusTcpClient.convert_to_registers(number, kind, word_order=order)
            self.registers[table][address : address + len(words)] = words
        self.is_up = False

    def start(self) -> None:
        ready = threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve(ready)), daemon=True)
        self._thread.start()
        assert ready.wait(5)
        self.is_up = True

    def stop(self) -> None:
        if self.is_up:
            self.is_up = False
            self._loop.call_soon_threadsafe(self._stopping.set)
            self._thread.join(5)

    def options(self, **changes: Any) -> dict[str, Any]:
        channels = {
            name: {"table": table, "address": address, "type": kind.name.lower(), "word_order": order}
            for name, (table, address, kind, order, _) in VALUES.items()
        }
        common = {"transport": "tcp", "host": "127.0.0.1", "port": self.port, "unit_id": UNIT, "answer_timeout": "100 ms"}
        return {**common, "retry_after": "50 ms", "channels": channels, **changes}

    async def _serve(self, ready: threading.Event) -> None:
        self._loop, self._stopping = asyncio.get_running_loop(), asyncio.Event()
        bits = [SimData(0, values=[False] * 16, datatype=DataType.BITS)]
        holding = [SimData(0, values=self.registers["holding"], datatype=DataType.REGISTERS)]
        inputs = [SimData(0, values=self.registers["input"], datatype=DataType.REGISTERS)]
        unit = SimDevice(id=UNIT, simdata=(bits, bits, holding, inputs), action=self._action)
        server = ModbusTcpServer(unit, address=("127.0.0.1", self.port))
        await server.serve_forever(background=True)
        ready.set()
        await self._stopping.wait()
        await server.shutdown()

    async def _action(self, function: int, start: int, address: int, count: int, registers: list[int], written: Any) -> ExcCodes | None:
        self.requests.append((function, address, count))
        while self.is_silent and not self._stopping.is_set():
            await asyncio.sleep(0.01)
        await asyncio.sleep(self.delay_s)
        table = self.registers["input" if function == 4 else "holding"]
        registers[: len(table)] = table
        return self.exception


def modbus_driver(options: dict[str, Any], name: str = "gauges") -> Driver:
    """Through the registry, as the I/O process makes it."""
    return create(name, Device(driver="modbus", slow=True, options=options), load_rig("ornl_testbed").rig, False)
