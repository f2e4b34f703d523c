"""A simulated Modbus unit: pressures and temperatures of the plant in registers, and what can be made wrong with it."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping

from pymodbus.constants import ExcCodes
from pymodbus.simulator import DataType, SimData, SimDevice

from config.errors import PlantError
from config.options.modbus_options import ModbusOptions
from sim_backend.twin.modbus.registers import span, words

_READ_HOLDING, _READ_INPUT = 3, 4
_POLL_S = 0.02
FAULTS = ("dead", "black_hole", "slow", "exception", "stuck", "jump")


class ModbusUnit:
    """`signals`: channel → signal of the rig. Counts are handed over by `update` from the plant's thread, encoded when asked for."""

    def __init__(self, name: str, options: ModbusOptions, signals: Mapping[str, str]) -> None:
        self.name = name
        self.requests = 0
        self._options = options
        self._signals = dict(signals)
        self._counts: dict[str, float] = {}
        self.clear()

    def clear(self) -> None:
        """Everything is right again."""
        self.is_dead = False
        self._black_hole = self._stuck = False
        self._slow_s = self._jump_counts = 0.0
        self._exception: ExcCodes | None = None

    def inject(self, fault: str, amount: float) -> None:
        """`dead` (no connection), `black_hole` (accepts, never answers), `slow` (ms), `exception` (code), `stuck`, `jump` (counts)."""
        if fault == "dead":
            self.is_dead = True
        elif fault == "black_hole":
            self._black_hole = True
        elif fault == "slow":
            self._slow_s = 1e-3 * amount
        elif fault == "exception":
            self._exception = ExcCodes(int(amount) or ExcCodes.DEVICE_FAILURE)
        elif fault == "stuck":
            self._stuck = True
        elif fault == "jump":
            self._jump_counts = amount
        else:
            raise PlantError("a Modbus unit has no such fault", value=fault, limit=", ".join(FAULTS), where=self.name)

    def describe(self) -> dict[str, float | str]:
        return {"requests": self.requests}

    def update(self, counts: Mapping[str, float]) -> None:
        """New counts of all signals."""
        if not self._stuck:
            self._counts = {channel: counts[signal] for channel, signal in self._signals.items() if signal in counts}

    def device(self) -> SimDevice:
        """For pymodbus' server: separate tables, and `_answer` before every answer."""
        coils = [SimData(0, values=[False] * 16, datatype=DataType.BITS)]
        discrete = [SimData(0, values=[False] * 16, datatype=DataType.BITS)]
        holding, inputs = self._table("holding"), self._table("input")
        return SimDevice(id=self._options.unit_id, simdata=(coils, discrete, holding, inputs), action=self._answer)

    def _table(self, table: str) -> list[SimData]:
        address, count = span(self._options.channels, table)
        return [SimData(address, values=[0] * count, datatype=DataType.REGISTERS)]

    async def _answer(
        self,
        function_code: int,
        start_address: int,
        address: int,
        count: int,
        registers: list[int],
        written: list[int] | list[bool] | None,
    ) -> ExcCodes | None:
        self.requests += 1
        while self._black_hole:
            await asyncio.sleep(_POLL_S)
        if self._slow_s:
            await asyncio.sleep(self._slow_s)
        if self._exception is not None:
            return self._exception
        if written is not None or function_code not in (_READ_HOLDING, _READ_INPUT):
            return ExcCodes.ILLEGAL_FUNCTION  # nothing here can be written
        table = "input" if function_code == _READ_INPUT else "holding"
        for name, channel in self._options.channels.items():
            if channel.table == table:
                shown = words(self._counts.get(name, 0.0) + self._jump_counts, channel)
                registers[channel.address - start_address : channel.address - start_address + len(shown)] = shown
        return None
