"""What a master does, with the canopen package's own network."""

from __future__ import annotations

import struct
import time

import canopen

from tests.support.sim_backend.twin_rig import VALVE

FULL = 16384


def pump_sync(running, seconds: float, also=lambda: None) -> None:
    """SYNC every millisecond, as a controller sends it."""
    end = time.monotonic() + seconds
    due = time.monotonic()
    while due < end:
        running.network.sync.transmit()
        also()
        due += 0.001
        time.sleep(max(0.0, due - time.monotonic()))


def operational(node: canopen.RemoteNode) -> None:
    node.sdo[0x1017].raw = 20
    node.nmt.state = "OPERATIONAL"
    while node.nmt.wait_for_heartbeat(5) != "OPERATIONAL":
        pass  # one from before the command


def command(running, word: int, set_point: int) -> None:
    running.network.send_message(0x200 + VALVE, struct.pack("<Hh", word, set_point))


def valve_active(running) -> canopen.RemoteNode:
    node = running.node(VALVE)
    operational(node)
    command(running, 0b0111, 0)
    running.eventually(lambda: node.sdo[0x6041].raw & 0xF == 0b1111, "ACTIVE")
    return node
