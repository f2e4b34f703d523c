"""A simulated encoder (CiA 406): position in counts, speed in counts/s, alarms."""

from __future__ import annotations

from sim_backend.twin.can.can_node import CanNode
from sim_backend.twin.can.object_store import Send

POSITION, SPEED, ALARMS, RESOLUTION = (0x6004, 0), (0x6030, 1), (0x6503, 0), (0x6501, 0)
POSITION_ERROR = 1  # alarm bit 0
_LARGEST_SPEED = 32767
_SPEED_WINDOW_PERIODS = 8  # the speed is the mean over so many updates, as a counting encoder's is


class Encoder(CanNode):
    """`resolution` is what 0x6501 says. `measure` gives it the true count once a plant period; a NaN (drop-out) leaves the position
    and raises the position alarm.
    """

    profile = "encoder_406"

    def __init__(self, name: str, node: int, send: Send, resolution: int = 0) -> None:
        self._resolution = resolution
        self._history: list[float] = []
        super().__init__(name, node, send)

    def powered_on(self) -> None:
        self._history.clear()
        self.store.values[RESOLUTION] = self._resolution

    def measure(self, count: float, period_s: float) -> None:
        """One update of the encoder's own sampling."""
        values = self.store.values
        if self.faults.stuck:
            return
        has_reading = count == count
        values[ALARMS] = self.faults.alarm_bits | (0 if has_reading else POSITION_ERROR)
        if not has_reading:
            return
        counted = round(self.faults.measured(count))
        values[POSITION] = counted & 0xFFFFFFFF
        values[SPEED] = self._speed(counted, period_s)

    def describe(self) -> dict[str, float | str]:
        return super().describe() | {"position": self.store.values[POSITION], "alarms": self.store.values[ALARMS]}

    def _speed(self, counted: float, period_s: float) -> int:
        self._history.append(counted)
        if len(self._history) > _SPEED_WINDOW_PERIODS + 1:
            del self._history[0]
        periods = len(self._history) - 1
        speed = (counted - self._history[0]) / (periods * period_s) if periods else 0.0
        return max(-_LARGEST_SPEED, min(_LARGEST_SPEED, round(speed)))
