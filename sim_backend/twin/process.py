"""The twin as a process: plant, CAN nodes and Modbus servers of a rig file, until SIGTERM or `stop`."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

from config.errors import ConfigError
from config.schema.rig import Rig
from sim_backend.plant import SimulatedRig
from sim_backend.twin.assembly import bench, can_bus
from sim_backend.twin.bench import SimulatedDevices
from sim_backend.twin.can.bus_faults import BusFaults
from sim_backend.twin.can.can_port import CanPort
from sim_backend.twin.control_socket import ControlSocket, obey
from sim_backend.twin.modbus.modbus_server import ModbusServers, modbus_units
from sim_backend.twin.real_time import ask_for_real_time

TICK_NS = 1_000_000
_STATUS_NS = 1_000_000_000
_SWITCH_INTERVAL_S = 1e-4  # the Modbus thread must not keep the CAN side waiting for Python's usual 5 ms


class Twin:
    """Everything behind the twin's sockets. `interface` and `channel` replace those of the rig file.

    ConfigError for a rig without a device on a bus or line: nobody could ever ask this twin.
    """

    def __init__(self, rig: Rig, interface: str = "", channel: str = "", control: Path | None = None, seed: int = 0) -> None:
        bus, units = can_bus(rig), modbus_units(rig)
        if bus is None and not units:
            advice = "longreachd simulates such a rig by itself; docs/guide/rig/hardware-twin.md shows devices to write."
            raise ConfigError("no device of the rig is on a CAN bus or a Modbus line", value=rig.name, where="devices", next_step=advice)
        self._port = CanPort(interface or bus.interface, channel or bus.channel) if bus else None
        self.bench: SimulatedDevices = bench(rig, SimulatedRig(rig, seed), self._port.send if self._port else _nowhere)
        self._bus_faults = BusFaults(self._port) if self._port else None
        if self._bus_faults:
            self.bench.devices["bus"] = self._bus_faults
        for unit in (unit for group in units.values() for unit in group):
            self.bench.add(unit.name, unit, unit.update)
        self._servers = ModbusServers(units) if units else None
        self._control = ControlSocket(control) if control else None
        self._stop = False

    def run(self, say: Callable[[str], None] | None = None, priority: int = 0, cpu: int | None = None) -> None:
        """Serve until `stop`; `say` gets one line a second. `priority`: SCHED_FIFO to ask for, 0 for none; `cpu`: the only processor
        to run on."""
        sys.setswitchinterval(_SWITCH_INTERVAL_S)
        granted = ask_for_real_time(priority, cpu)  # before the Modbus thread, which may not be kept waiting while it has Python's lock
        if say:
            say(f"twin: {granted}")
        if self._servers:
            self._servers.start()
        now = time.monotonic_ns()
        self.bench.start(now)
        tick_ns = status_ns = now
        try:
            while not self._stop:
                self._receive((tick_ns + TICK_NS - time.monotonic_ns()) * 1e-9)
                now = time.monotonic_ns()
                if now >= tick_ns + TICK_NS:
                    tick_ns = now
                    self._tick(now)
                if say and now >= status_ns + _STATUS_NS:
                    status_ns = now
                    say(self.status())
        finally:
            self._close()

    def stop(self) -> None:
        """May be called from a signal handler or another thread."""
        self._stop = True

    def status(self) -> str:
        """One line for a person."""
        bench = self.bench
        nodes = " ".join(f"{node.name}={node.describe().get('state', node.describe()['nmt'])}" for node in bench.nodes)
        dropped = f" dropped={self._port.dropped}" if self._port and self._port.dropped else ""
        syncs = f"{bench.syncs} SYNC, {bench.unanswered} too late to answer"
        return f"plant {bench.feed.plant.time_s:.1f} s, {syncs}, {bench.clock.caught_up} caught up; {nodes}{dropped}"

    def _receive(self, timeout_s: float) -> None:
        if self._port is None:
            time.sleep(max(0.0, timeout_s))
            return
        frames = self._port.receive(max(0.0, timeout_s))
        if frames:
            self.bench.on_frames(frames, time.monotonic_ns())

    def _tick(self, now_ns: int) -> None:
        self.bench.tick(now_ns)
        if self._bus_faults:
            self._bus_faults.tick(now_ns)
        if self._control is None:
            return
        asked = self._control.request()
        if asked is not None:
            content, sender = asked
            self._control.answer(sender, obey(self.bench, content, now_ns))

    def _close(self) -> None:
        if self._servers:
            self._servers.close()
        if self._control:
            self._control.close()
        if self._port:
            self._port.close()


def _nowhere(cob_id: int, data: bytes) -> None:
    """Where frames go when the rig has no CAN bus."""
