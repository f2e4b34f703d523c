"""longreachd as systemd runs it inside a test machine."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from daemon.server.protocol import Client
from tests.systemd.nspawn_machine import Machine, eventually

UNIT, REPORTS = "longreachd.service", "longreach-reports.service"
START_LIMIT_S = 30.0


class Service:
    """The unit, its processes and its socket."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.socket = machine.path("/run/longreach/longreach.sock")
        self.logs = machine.path("/var/log/longreach")

    def systemctl(self, *arguments: str, check: bool = True) -> str:
        return self.machine.run("systemctl", *arguments, check=check, limit_s=200).stdout

    def show(self, name: str) -> str:
        return self.systemctl("show", UNIT, "--value", "-p", name).strip()

    def forgive(self) -> None:
        """Nothing counted against its start limit, no restarts counted."""
        self.systemctl("reset-failed", UNIT, check=False)

    def up(self) -> None:
        """Running and disarmed, as it is or newly started: a test that failed may have left it faulted."""
        self.forgive()
        self.systemctl("start", UNIT)
        if self.mode() != "disarmed":
            self.systemctl("restart", UNIT)
        assert self.mode() == "disarmed"

    def fresh(self) -> None:
        """Newly started."""
        self.systemctl("stop", UNIT)
        self.up()

    def pid(self, role: str) -> str:
        """Process number inside the machine; role: main, control, recorder."""
        if role == "main":
            return self.show("MainPID")
        return self.machine.run("pgrep", "-f", f"daemon.processes.{role}_process", check=True).stdout.strip()

    def signal(self, name: str, role: str) -> None:
        self.machine.run("kill", "-s", name, self.pid(role), check=True)

    def process_facts(self, role: str) -> dict[str, str]:
        """/proc/PID/status."""
        lines = self.machine.path(f"/proc/{self.pid(role)}/status").read_text().splitlines()
        return {key: value.strip() for key, _, value in (line.partition(":") for line in lines)}

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        with Client(self.socket) as client:
            return client.call(method, **params)

    def status(self) -> dict[str, Any]:
        return self.call("status")

    def hold(self) -> None:
        """Armed, at rest."""
        self.call("reset")
        self.call("arm")

    def move(self) -> None:
        """Armed and in the middle of a maneuver."""
        self.hold()
        self.call("start", maneuver={"name": "slow_triangle"}, approach=True, countdown_s=0.0)
        eventually("the run has gone on for a second", lambda: self.mode() == "running" and self.status()["run"]["elapsed_s"] > 1.0, 10)

    def mode(self) -> str:
        return str(self.status()["mode"])

    def restarted(self) -> float:
        """Wait until systemd has started it again by itself; the seconds that took."""
        return eventually("it is up again", lambda: int(self.show("NRestarts")) > 0 and self.show("ActiveState") == "active", START_LIMIT_S)

    def journal(self) -> str:
        """What the unit, and systemd about it, have said since the machine was booted."""
        return self.machine.run("journalctl", "-u", UNIT, "-o", "short-monotonic", "--no-hostname").stdout

    def recording(self) -> Path:
        """The log that is being written."""
        return self.machine.path(self.status()["log"]["path"])
