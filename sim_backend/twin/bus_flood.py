"""A babbling device: frames that nobody asked for, at a given rate, to see what the controller does on a full bus."""

from __future__ import annotations

from config.errors import PlantError
from sim_backend.twin.object_store import Send

FLOOD_ID = 0x001  # below SYNC, so that on a real bus every other frame waits for it
_FRAME = bytes(8)
_MOST_FRAMES_A_TICK = 1000


class BusFlood:
    """The device "bus" of a bench. Its only fault is `flood`, with frames a second."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self._per_s = 0.0
        self._last_ns = 0
        self._owed = 0.0
        self.sent = 0

    def inject(self, fault: str, amount: float) -> None:
        if fault != "flood":
            raise PlantError("the bus has no such fault", value=fault, limit="flood")
        self._per_s = max(0.0, amount)

    def clear(self) -> None:
        self._per_s = self._owed = 0.0

    def describe(self) -> dict[str, float | str]:
        return {"flood_frames": self.sent}

    def tick(self, now_ns: int) -> None:
        """Send what is owed since the last tick."""
        self._owed += self._per_s * (now_ns - self._last_ns) * 1e-9 if self._last_ns else 0.0
        self._last_ns = now_ns
        for _ in range(min(int(self._owed), _MOST_FRAMES_A_TICK)):
            self._send(FLOOD_ID, _FRAME)
            self.sent += 1
        self._owed %= 1.0
