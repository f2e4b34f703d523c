"""A simulated analogue I/O module (CiA 401): four outputs and four inputs of 16 bits, and what the outputs do when the master is gone.

An output with error mode 1 (0x6443) takes its error value (0x6444) when the communication is lost or the node leaves OPERATIONAL;
with error mode 0, the default of many modules, it keeps the last value: a driver has to write the mode.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from sim_backend.twin.can.can_node import OPERATIONAL, CanNode
from sim_backend.twin.can.object_store import Send

INPUT, OUTPUT, ERROR_MODE, ERROR_VALUE = 0x6401, 0x6411, 0x6443, 0x6444
CHANNELS = 4
_TAKE_ERROR_VALUE = 1


class AnalogIo(CanNode):
    """`safe_since_ns`: when the outputs took their error values; None while they are what the master wrote.

    `wires`: {output: input}, channels counted from 1, that are connected at the terminals.
    """

    profile = "io_401"

    def __init__(self, name: str, node: int, send: Send, wires: Mapping[int, int] | None = None) -> None:
        self._wires = dict(wires or {})
        self.outputs = [0] * CHANNELS  # at the terminals; 0x6411 is what was written
        self.safe_since_ns: int | None = 0
        self._became_safe = False
        super().__init__(name, node, send)

    def powered_on(self) -> None:
        self.outputs = [0] * CHANNELS
        self._became_safe = True

    def received(self) -> None:
        self.outputs = [self.store.values[OUTPUT, sub] for sub in range(1, CHANNELS + 1)]
        self.safe_since_ns, self._became_safe = None, False
        self._sample_wires()

    def object_written(self, index: int) -> None:
        if index == OUTPUT and self.state == OPERATIONAL:
            self.received()

    def left_operational(self) -> None:
        self._error_values()

    def communication_lost(self, code: int) -> None:
        self._error_values()

    def measure(self, counts: Sequence[float]) -> None:
        """The counts at the inputs; a NaN (broken wire) reads as the lowest count, as it does with 4..20 mA."""
        if self.faults.stuck:
            return
        for sub, count in enumerate(counts, 1):
            if sub in self._wires.values():
                continue
            shown = round(self.faults.measured(count)) if count == count else -32768
            self.store.values[INPUT, sub] = max(-32768, min(32767, shown))

    def terminal(self, number: int, now_ns: int) -> int:
        """Counts at output `number` (from 0), once a plant period; dates the change to the error values."""
        if self._became_safe:
            self.safe_since_ns, self._became_safe = now_ns, False
        return self.outputs[number]

    def describe(self) -> dict[str, float | str]:
        safe = {"safe_since_ns": self.safe_since_ns} if self.safe_since_ns is not None else {}
        return super().describe() | {f"output_{number}": counts for number, counts in enumerate(self.outputs, 1)} | safe

    def _error_values(self) -> None:
        values = self.store.values
        modes = [values[ERROR_MODE, number + 1] for number in range(CHANNELS)]
        for number, mode in enumerate(modes):
            if mode == _TAKE_ERROR_VALUE:
                self.outputs[number] = max(-32768, min(32767, values[ERROR_VALUE, number + 1]))
        self._became_safe = all(mode == _TAKE_ERROR_VALUE or output == 0 for mode, output in zip(modes, self.outputs, strict=True))
        self._sample_wires()

    def _sample_wires(self) -> None:
        """The input converter runs much faster than the plant is stepped: a wire shows its output at once."""
        for output, into in self._wires.items():
            self.store.values[INPUT, into] = self.outputs[output - 1]
