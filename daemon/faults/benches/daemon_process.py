"""A real longreachd with its child processes, which may be killed, stopped and asked for anything."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from config.errors import DaemonError
from config.loading.load import apply_overrides
from daemon.faults.benches.lockstep_bench import loaded_rig
from daemon.server.protocol import Client
from drivers.output_register import OutputRegister

START_LIMIT_S = 120.0
POLL_S = 0.01
# A shared computer makes the loop late now and then, which is a fault of its own.
PATIENCE = ("loop.overruns.stop_after=1000", "loop.countdown=0 s")


class DaemonProcess:
    """longreachd in `directory`. Use it in a with statement, or end() it."""

    def __init__(
        self,
        directory: Path,
        overrides: Sequence[str] = (),
        text: str | None = None,
        environment: Mapping[str, str] | None = None,
        log_dir: Path | None = None,
        prefix: Sequence[str] = (),
    ) -> None:
        """`overrides` of the rig file `text` (default: the test bed's); `log_dir`: not the one in `directory`; `prefix`: words before the
        command, such as those that lead into a network namespace.
        """
        rig = directory / "rig.yaml"
        rig.write_text(apply_overrides(text or loaded_rig().text, [*PATIENCE, *overrides]))
        self.runtime, self._journal = directory / "run", directory / "journal.txt"
        logs = log_dir or directory / "logs"
        places = ["--runtime-dir", str(self.runtime), "--log-dir", str(logs)]
        self.command = [*prefix, sys.executable, "-m", "daemon.processes.supervisor", str(rig), *places]
        with self._journal.open("wb") as output:
            self._process = subprocess.Popen(
                self.command, stdout=output, stderr=subprocess.STDOUT, env={**os.environ, **(environment or {})}
            )
        self._children: dict[str, int] = {}

    @property
    def socket(self) -> Path:
        return self.runtime / "longreach.sock"

    def connect(self) -> Client:
        """A client, once the daemon answers. DaemonError with the end of its output when it does not."""
        limit = time.monotonic() + START_LIMIT_S
        while self._process.poll() is None and time.monotonic() < limit:
            with suppress(DaemonError):
                client = Client(self.socket)
                self._children = _children(self._process.pid)
                return client
            time.sleep(POLL_S)
        raise DaemonError("the daemon did not start", value=self._journal.read_text(errors="replace")[-500:], limit=START_LIMIT_S, unit="s")

    def register(self) -> OutputRegister:
        return OutputRegister.attach(self.runtime / "plant.outputs")

    def pid(self, name: str) -> int:
        """Process id of supervisor, control, recorder or io."""
        return self._process.pid if name == "supervisor" else self._children[f"daemon.processes.{name}_process"]

    def signal(self, number: int, *names: str) -> None:
        for name in names:
            os.kill(self.pid(name), number)

    def is_alive(self, name: str) -> bool:
        return _belongs_to_daemon(self.pid(name))

    def exit_status(self) -> int | None:
        return self._process.poll()

    def __enter__(self) -> DaemonProcess:
        return self

    def __exit__(self, *error: object) -> None:
        self.end()

    def end(self) -> None:
        """Whatever is left is killed."""
        for pid in (self._process.pid, *self._children.values()):
            if pid == self._process.pid or _belongs_to_daemon(pid):
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
        self._process.wait(10)


def move(client: Client, way_deg: float, speed: str) -> None:
    """Arm if need be and start a long move of the rotary joint, away from the nearer end. Returns when the arm is at speed.

    DaemonError at a fault on the way, and when arming is refused for too long.
    """
    hold(client)
    position = client.call("status")["joints"]["rotary"]["position"]
    parameters = {"joint": "rotary", "by": f"{-way_deg if position > 0 else way_deg} deg", "speed": speed}
    client.call("start", maneuver={"name": "jog"}, parameters=parameters, countdown_s=0.0)
    wait_for(lambda: _at_speed(client))


def hold(client: Client, limit_s: float = 10.0) -> None:
    """Whatever the mode, the arm is held afterwards; arming is refused until every device has given its first good sample."""
    mode = _mode(client)
    if mode == "holding":
        return
    client.call("reset" if mode in ("fault", "disarmed") else "disarm")
    wait_for(lambda: _armed(client), limit_s)
    wait_for(lambda: _mode(client) == "holding", limit_s)


def wait_for(condition: Callable[[], Any], limit_s: float = 10.0) -> None:
    limit = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > limit:
            raise DaemonError("what was waited for did not happen", limit=limit_s, unit="s")
        time.sleep(POLL_S)


def _armed(client: Client) -> bool:
    with suppress(DaemonError):
        client.call("arm")
        return True
    return False


def _at_speed(client: Client) -> bool:
    status = client.call("status")
    if status["mode"] == "fault":
        raise DaemonError("a fault that nobody injected", value=str(status["fault"]))
    return bool(status["mode"] == "running" and status["run"]["elapsed_s"] > 0.3)


def _mode(client: Client) -> str:
    return str(client.call("status")["mode"])


def _children(parent: int) -> dict[str, int]:
    """module → process id of every `python -m MODULE` child of `parent`."""
    found = {}
    for directory in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, IndexError):
            if int((directory / "stat").read_text().rpartition(")")[2].split()[1]) == parent:
                words = (directory / "cmdline").read_bytes().split(b"\0")
                if b"-m" in words:
                    found[words[words.index(b"-m") + 1].decode()] = int(directory.name)
    return found


def _belongs_to_daemon(pid: int) -> bool:
    """Process ids are used again: this one may belong to another program."""
    with suppress(OSError):
        return b"daemon." in Path(f"/proc/{pid}/cmdline").read_bytes()
    return False
