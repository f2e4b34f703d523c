"""Somebody who drives by hand, on both benches: in lockstep beside the loop, and as a program of its own with a network between."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from select import select
from threading import Event, Thread

from config.errors import DaemonError
from daemon.faults.benches.daemon_process import hold, wait_for
from daemon.lockstep import LockstepRig
from daemon.server.protocol import Client
from servo_control.signals import Mode, SetPoint, Wanted

EVERY_CYCLES = 20
RATES = {"rotary": (0.8, 0.0), "prismatic": (0.0, -0.2)}  # rad/s and m/s
PROGRAM_RATE = 0.35  # rad/s
_PROGRAM = """
import sys, time
from daemon.server.protocol import Client
from daemon.server.stream_client import Stream
with Client(sys.argv[1]) as client, Stream(client, countdown_s=0.0) as stream:
    while True:
        stream.rate(rotary=float(sys.argv[2]))
        time.sleep(0.02)
"""


class LockstepHand:
    """Sends the same set point every twenty cycles. `point` may be changed; with `silent` nothing comes any more."""

    def __init__(self, rig: LockstepRig, joint: str) -> None:
        self._rig, self._cycle = rig, 0
        self.point = SetPoint(rig.stream(), Wanted.RATE, RATES[joint], 0.0)
        self.silent = False
        rig.until(lambda: rig.mode is Mode.RUNNING)

    def before_cycle(self) -> None:
        if not self.silent and self._cycle % EVERY_CYCLES == 0:
            self._rig.set_points.post(self.point)
        self._cycle += 1


class Relay:
    """Passes on what client and daemon send each other, until it is `stalled`: then both connections stay open and nothing comes."""

    def __init__(self, path: Path, daemon: Path) -> None:
        self.path, self._daemon, self.stalled, self._ended = path, daemon, Event(), Event()
        path.unlink(missing_ok=True)
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(path))
        self._listener.listen(1)
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        with suppress(OSError), self._listener, self._listener.accept()[0] as client, socket.socket(socket.AF_UNIX) as daemon:
            daemon.connect(str(self._daemon))
            while not self._ended.is_set():
                self._pass_on(client, daemon)

    def _pass_on(self, client: socket.socket, daemon: socket.socket) -> None:
        ready, _, _ = select([client, daemon], [], [], 0.01)
        for end in ready if not self.stalled.is_set() else ():
            data = end.recv(65536)
            if not data:
                self._ended.set()
            (daemon if end is client else client).sendall(data)
        if self.stalled.is_set():
            time.sleep(0.01)

    def end(self) -> None:
        self._ended.set()
        self._listener.close()


class HandProgram:
    """A program that turns the rotary joint by hand, away from the nearer end, through a relay."""

    def __init__(self, client: Client, daemon: Path, directory: Path) -> None:
        """Returns when the arm is at speed. DaemonError when it does not come to that."""
        hold(client)
        runs_before = (client.call("status")["run"] or {"run": 0})["run"]
        away = -PROGRAM_RATE if client.call("status")["joints"]["rotary"]["position"] > 0.0 else PROGRAM_RATE
        self.relay = Relay(directory / "hand.sock", daemon)
        self.process = subprocess.Popen([sys.executable, "-c", _PROGRAM, str(self.relay.path), str(away)], stderr=subprocess.DEVNULL)
        try:
            wait_for(lambda: _at_speed(client, runs_before))
        except DaemonError:
            self.end()
            raise

    def end(self) -> None:
        self.process.kill()
        self.process.wait(10)
        self.relay.end()


def _at_speed(client: Client, runs_before: int) -> bool:
    status = client.call("status")
    run = status["run"]
    return bool(run and run["run"] > runs_before and status["mode"] == "running" and run["elapsed_s"] > 0.8)
