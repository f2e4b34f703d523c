"""The twin's way onto a CAN bus: python-can's virtual (one process), udp_multicast (one network namespace) or socketcan."""

from __future__ import annotations

import time
from typing import NamedTuple

import can

from config.errors import PlantError
from config.options.multicast import refuse_leaking_multicast

MOST_FRAMES = 256  # taken at once; what else has arrived is taken next time
_BUS_OFF, _RESTARTED = 0x040, 0x100  # classes of SocketCAN's error frames
_OLDEST_NS = 1_000_000_000  # a stamp further away was made by a wall clock that has been set since


class Frame(NamedTuple):
    """A data frame with an 11-bit identifier, and when it arrived on the monotonic clock."""

    cob_id: int
    data: bytes
    arrived_ns: int


class CanPort:
    """Frames in and out. A frame that cannot be sent is dropped and counted, as a controller with a full mailbox does."""

    def __init__(self, interface: str, channel: str) -> None:
        if interface == "udp_multicast":
            refuse_leaking_multicast(channel)
        try:
            self._bus = can.Bus(interface=interface, channel=channel)
        except (can.CanError, OSError, ValueError, ImportError) as error:
            advice = "For socketcan: ip link show; for udp_multicast: run in a network namespace with a multicast route on lo."
            raise PlantError("the CAN bus cannot be opened", value=str(error), where=f"{interface} {channel}", next_step=advice) from error
        self.is_off = False
        self.is_full = False  # of frames that go first
        self.dropped = 0
        self.malformed = 0

    def send(self, cob_id: int, data: bytes) -> None:
        if not (self.is_off or self.is_full):
            self._transmit(can.Message(arbitration_id=cob_id, data=data, is_extended_id=False))

    def send_first(self, cob_id: int, data: bytes) -> None:
        """A frame that wins every arbitration."""
        if not self.is_off:
            self._transmit(can.Message(arbitration_id=cob_id, data=data, is_extended_id=False))

    def switch(self, is_off: bool) -> None:
        """Bus-off and its end: the master's interface says so by an error frame as SocketCAN's do, and nothing passes while it lasts."""
        if is_off != self.is_off:
            self.is_off = is_off
            self._transmit(can.Message(arbitration_id=_BUS_OFF if is_off else _RESTARTED, data=bytes(8), is_error_frame=True))

    def receive(self, timeout_s: float) -> list[Frame]:
        """What has arrived, in order; waits for the first frame at most so long."""
        frames: list[Frame] = []
        for number in range(MOST_FRAMES):
            try:
                message = self._bus.recv(0.0 if number else timeout_s)
            except Exception:  # udp_multicast unpacks whatever a datagram holds
                self.malformed += 1
                continue
            if message is None:
                break
            passes = not (self.is_off or self.is_full)
            if passes and not (message.is_extended_id or message.is_remote_frame or message.is_error_frame):
                frames.append(Frame(message.arbitration_id, bytes(message.data), _arrival_ns(message.timestamp)))
        return frames

    def close(self) -> None:
        self._bus.shutdown()

    def _transmit(self, message: can.Message) -> None:
        try:
            self._bus.send(message, 0)
        except (can.CanError, OSError):
            self.dropped += 1


def _arrival_ns(stamp_s: float) -> int:
    """On the monotonic clock; an interface stamps with the wall clock."""
    ago_ns = time.time_ns() - int(1e9 * stamp_s)
    return time.monotonic_ns() - (ago_ns if 0 <= ago_ns <= _OLDEST_NS else 0)
