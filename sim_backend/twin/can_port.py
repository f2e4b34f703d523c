"""The twin's way onto a CAN bus: python-can's virtual (one process), udp_multicast (one network namespace) or socketcan."""

from __future__ import annotations

import ipaddress
import subprocess

import can

from config.errors import PlantError

MULTICAST_GROUP = "239.74.163.2"


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


def refuse_leaking_multicast(group: str) -> None:
    """Frames of udp_multicast follow the default route: refuse unless they stay on the loopback device.

    Raises PlantError naming the device the kernel would use.
    """
    try:
        is_multicast = ipaddress.IPv4Address(group).is_multicast
    except ValueError as error:
        advice = f"Use an IPv4 multicast group such as {MULTICAST_GROUP}."
        raise PlantError("the channel of udp_multicast is no IPv4 group", value=group, next_step=advice) from error
    route = subprocess.run(["ip", "-4", "route", "get", group], capture_output=True, text=True, check=False)
    if not is_multicast or " dev lo " not in f"{route.stdout} ":
        value = (route.stdout or route.stderr).split("\n")[0].strip()
        advice = "Run in a network namespace: ip netns add N; ip -n N link set lo up multicast on; ip -n N route add 224.0.0.0/4 dev lo"
        raise PlantError("udp_multicast frames would leave this machine", value=value, limit="dev lo", where=group, next_step=advice)
