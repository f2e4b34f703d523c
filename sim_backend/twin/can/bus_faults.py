"""What can be wrong with the bus itself: a babbling device that fills it, and a master whose controller has gone bus-off."""

from __future__ import annotations

from config.errors import PlantError
from sim_backend.twin.can.can_port import CanPort

FLOOD_ID = 0x001  # below SYNC, so that on a real bus every other frame waits for it
FAULTS = ("flood", "bus_off")
FULL_PER_S = 7000  # frames of eight bytes that fill 1 Mbit/s (about 130 bits each, stuffing included)
_FRAME = bytes(8)
_MOST_FRAMES_A_TICK = 1000


class BusFaults:
    """The device "bus" of a bench. `flood`: frames a second that nobody asked for, and from FULL_PER_S on no others, because on a real
    bus these win every arbitration; `bus_off`: an error frame, then silence.
    """

    def __init__(self, port: CanPort) -> None:
        self._port = port
        self._per_s = 0.0
        self._last_ns = 0
        self._owed = 0.0
        self.sent = 0

    def inject(self, fault: str, amount: float) -> None:
        if fault == "flood":
            self._per_s = max(0.0, amount)
            self._port.is_full = self._per_s >= FULL_PER_S
        elif fault == "bus_off":
            self._port.switch(is_off=True)
        else:
            raise PlantError("the bus has no such fault", value=fault, limit=", ".join(FAULTS))

    def clear(self) -> None:
        self._per_s = self._owed = 0.0
        self._port.is_full = False
        self._port.switch(is_off=False)

    def describe(self) -> dict[str, float | str]:
        return {"flood_frames": self.sent, "dropped": self._port.dropped, "malformed": self._port.malformed}

    def tick(self, now_ns: int) -> None:
        """Send what is owed since the last tick."""
        self._owed += self._per_s * (now_ns - self._last_ns) * 1e-9 if self._last_ns else 0.0
        self._last_ns = now_ns
        for _ in range(min(int(self._owed), _MOST_FRAMES_A_TICK)):
            self._port.send_first(FLOOD_ID, _FRAME)
            self.sent += 1
        self._owed %= 1.0
