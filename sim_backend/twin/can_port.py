"""The twin's way onto a CAN bus: python-can's virtual (one process), udp_multicast (one network namespace) or socketcan."""

from __future__ import annotations

import can

from config.errors import PlantError
from config.multicast import refuse_leaking_multicast


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
        self.dropped = 0
        self.malformed = 0

    def send(self, cob_id: int, data: bytes) -> None:
        try:
            self._bus.send(can.Message(arbitration_id=cob_id, data=data, is_extended_id=False), 0)
        except (can.CanError, OSError):
            self.dropped += 1

    def receive(self, timeout_s: float) -> tuple[int, bytes] | None:
        """The next data frame with an 11-bit identifier; None when none comes in time or it is of another kind."""
        try:
            message = self._bus.recv(timeout_s)
        except Exception:  # udp_multicast unpacks whatever a datagram holds
            self.malformed += 1
            return None
        if message is None or message.is_extended_id or message.is_remote_frame or message.is_error_frame:
            return None
        return message.arbitration_id, bytes(message.data)

    def close(self) -> None:
        self._bus.shutdown()
