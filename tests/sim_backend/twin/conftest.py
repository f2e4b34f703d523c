"""A twin on a virtual bus in a thread, and a client that is not ours: the canopen package's network."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import can
import canopen
import pytest

from config.schema.rig import Rig
from sim_backend.twin.control_socket import TwinControl
from sim_backend.twin.process import Twin
from tests.support.sim_backend.twin_rig import free_port, twin_rig

_channels = itertools.count()


class RunningTwin:
    """`network`: canopen's own master on the twin's bus. `control`: the socket for faults."""

    def __init__(self, rig: Rig, channel: str, modbus_port: int, control: Path) -> None:
        self.rig = rig
        self.modbus_port = modbus_port
        self.twin = Twin(rig, "virtual", channel, control)
        self.network = canopen.Network()
        self.network.NOTIFIER_CYCLE = 0.02
        self.network.connect(interface="virtual", channel=channel)
        self.raw_bus = can.Bus(interface="virtual", channel=channel)
        self._thread = threading.Thread(target=self.twin.run, daemon=True)
        self._thread.start()
        self.control = TwinControl(control, timeout_s=20)
        self.eventually(lambda: self.twin.bench.clock.caught_up > 0, "the twin runs")

    def node(self, number: int) -> canopen.RemoteNode:
        profile = {3: "encoder_406", 4: "encoder_406", 5: "valve_408", 6: "io_401"}[number]
        node = self.network.add_node(number, f"config/eds/{profile}.eds")
        node.sdo.RESPONSE_TIMEOUT = 5.0  # a busy machine
        return node

    def eventually(self, condition: Callable[[], bool], what: str, limit_s: float = 20.0) -> float:
        """Waits for a condition; returns the seconds it took."""
        start = time.monotonic()
        while not condition():
            assert time.monotonic() - start < limit_s, f"not within {limit_s} s: {what}"
            time.sleep(0.0005)
        return time.monotonic() - start

    def close(self) -> None:
        self.control.close()
        self.network.disconnect()
        self.raw_bus.shutdown()
        self.twin.stop()
        self._thread.join(10)
        assert not self._thread.is_alive()


@pytest.fixture
def running(tmp_path: Path) -> Iterator[RunningTwin]:
    channel, port = f"twin{next(_channels)}", free_port()
    twin = RunningTwin(twin_rig(channel, port), channel, port, tmp_path / "twin.sock")
    yield twin
    twin.close()
