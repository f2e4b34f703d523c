"""What the frames on a CAN bus say by themselves, heard without sending anything (CiA 301: predefined connection set)."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import can

from drivers.canopen.bus import HEARTBEAT_ID, SYNC_ID
from drivers.canopen.sdo_upload import ANSWER_ID, REQUEST_ID

_NMT_ID = 0x000
_STATES = {0: "boot-up", 4: "stopped", 5: "operational", 127: "pre-operational"}
_PROCESS_DATA = {0x180: "TPDO1", 0x280: "TPDO2", 0x380: "TPDO3", 0x480: "TPDO4"}
_SERVICE, _NODE = 0x780, 0x07F


@dataclass(slots=True)
class Traffic:
    """`nodes`: number → what it sent, in the order heard. `masters`: what only a master sends."""

    frames: int = 0
    error_frames: int = 0
    nodes: dict[int, list[str]] = field(default_factory=dict)
    masters: set[str] = field(default_factory=set)

    def take(self, message: can.Message) -> None:
        """One frame."""
        if message.is_error_frame:
            self.error_frames += 1
            return
        self.frames += 1
        if not message.is_extended_id and not message.is_remote_frame:
            self._understand(message.arbitration_id, bytes(message.data))

    def _understand(self, identifier: int, data: bytes) -> None:
        service, node = identifier & _SERVICE, identifier & _NODE
        if identifier in (_NMT_ID, SYNC_ID):
            self.masters.add("NMT commands" if identifier == _NMT_ID else "SYNC")
        elif service == REQUEST_ID:
            self.masters.add("SDO requests")
        elif service == HEARTBEAT_ID and len(data) == 1:
            self._heard(node, _STATES.get(data[0] & 0x7F, f"NMT state {data[0] & 0x7F}"))
        elif service == SYNC_ID and len(data) == 8:
            self._heard(node, f"emergency 0x{data[1]:02X}{data[0]:02X}")
        elif service == ANSWER_ID:
            self._heard(node, "SDO")
        elif service in _PROCESS_DATA:
            self._heard(node, _PROCESS_DATA[service])

    def _heard(self, node: int, what: str) -> None:
        said = self.nodes.setdefault(node, [])
        if node and what not in said:
            said.append(what)


def listen(bus: can.BusABC, traffic: Traffic, seconds: float) -> None:
    """Take every frame that comes within so long."""
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        try:
            message = bus.recv(left)
        except Exception:  # whatever an interface raises for bytes that are no frame (udp_multicast carries anything)
            traffic.error_frames += 1
            continue
        if message is not None:
            traffic.take(message)
