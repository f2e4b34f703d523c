"""A pytest plugin: the tests of the CANopen drivers, whose nodes and drivers meet on a virtual bus, meet on SocketCAN instead."""

from __future__ import annotations

import itertools
import os
import subprocess
from typing import Any

import can

from tests.support.drivers import canopen_rig, local_nodes

_numbers = itertools.count()


def new_interface() -> str:
    """A virtual CAN interface of its own for every test, as the virtual buses have names of their own."""
    name = f"vcan{os.getpid()}.{next(_numbers)}"
    subprocess.run(["ip", "link", "add", name, "type", "vcan"], check=True)
    subprocess.run(["ip", "link", "set", name, "up"], check=True)
    return name


class VcanBench(local_nodes.NodeBench):
    """The simulated nodes on SocketCAN, with a second socket for the mark that tells when they have handled all that was sent."""

    def __init__(self, channel: str) -> None:
        super().__init__(channel)
        self.bus.shutdown()
        self.channel = new_interface()
        self.bus = self.network.bus = can.Bus(interface="socketcan", channel=self.channel)
        self._marking = can.Bus(interface="socketcan", channel=self.channel)

    def settle(self) -> None:
        self._settled.clear()
        self._marking.send(can.Message(arbitration_id=local_nodes._MARKER, is_extended_id=False))
        assert self._settled.wait(5.0)

    def __exit__(self, *error: object) -> None:
        super().__exit__(*error)
        self._marking.shutdown()


def on_socketcan(channel: str) -> dict[str, Any]:
    return {"interface": "socketcan", "channel": channel}


local_nodes.NodeBench = VcanBench
canopen_rig.bus = on_socketcan
