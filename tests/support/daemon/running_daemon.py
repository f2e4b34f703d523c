"""A real longreachd with its child processes, for tests on the wall clock."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from config.errors import DaemonError
from config.loading.load import apply_overrides, load_rig
from daemon.server.protocol import Client
from tests.support.daemon import processes

START_LIMIT_S = 120.0


class RunningDaemon:
    """longreachd in `directory`. Use it in a with statement; whatever is left is killed at its end."""

    def __init__(self, directory: Path, rig: str | None = None, environment: dict[str, str] | None = None) -> None:
        """`rig`: file or name; left out, the Oak Ridge rig with patience for a busy machine."""
        rig = rig or str(patient_rig(directory))
        self.directory, self.runtime, self.logs = directory, directory / "run", directory / "logs"
        self.socket = self.runtime / "longreach.sock"
        self.journal = directory / f"journal-{time.monotonic_ns()}.txt"
        command = [
            sys.executable,
            "-m",
            "daemon.processes.supervisor",
            rig,
            "--runtime-dir",
            str(self.runtime),
            "--log-dir",
            str(self.logs),
        ]
        with self.journal.open("wb") as output:
            self.process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT, env={**os.environ, **(environment or {})})
        self._children: dict[str, int] = {}

    def wait_until_ready(self) -> Client:
        """A client of the daemon, once it answers."""
        found: list[Client] = []

        def connect() -> bool:
            assert self.process.poll() is None, self.text()
            try:
                found.append(Client(self.socket))
            except DaemonError:
                return False
            return True

        until(connect, START_LIMIT_S)
        self._children = processes.children(self.process.pid)
        return found[0]

    def child(self, name: str) -> int:
        """Process id of control, recorder or io."""
        return self._children[f"daemon.processes.{name}_process"]

    def text(self) -> str:
        return self.journal.read_text(errors="replace")

    def latest_log(self) -> Path:
        """The newest recording of an armed rig."""
        armed = [path for path in self.logs.glob("*.mcap") if not path.stem.endswith("-standby")]
        return max(armed, key=lambda path: path.stat().st_mtime_ns)

    def all_ended(self) -> bool:
        return self.process.poll() is not None and not any(processes.is_alive(pid) for pid in self._children.values())

    def __enter__(self) -> RunningDaemon:
        return self

    def __exit__(self, *error: object) -> None:
        children = processes.children(self.process.pid) if self.process.poll() is None else self._children
        for pid in (self.process.pid, *children.values()):
            if pid == self.process.pid or processes.is_alive(pid):
                processes.kill(pid)
        self.process.wait(10)


def patient_rig(directory: Path) -> Path:
    """The shipped rig, but the loop may be late as a shared virtual machine makes it: these tests are not about that."""
    path = directory / "patient.yaml"
    if not path.exists():
        path.write_text(apply_overrides(load_rig("ornl_testbed").text, ["loop.overruns.fault_late=1 s", "loop.overruns.stop_after=1000"]))
    return path


def until(condition: Callable[[], Any], limit_s: float = 10.0) -> None:
    """Wait for a condition; AssertionError when it does not come about."""
    limit = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < limit, f"not within {limit_s} s"
        time.sleep(0.002)


def arm(client: Client) -> None:
    client.call("reset")
    client.call("arm")


def terminate(daemon: RunningDaemon) -> None:
    daemon.process.send_signal(signal.SIGTERM)
