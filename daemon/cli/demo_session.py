"""The demo's three runs, either through a real daemon on the wall clock or in lockstep, as fast as the computer can."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from config.errors import DaemonError
from daemon.cli.motion_commands import wait_for
from daemon.protocol import Client

_START_LIMIT_S = 90.0  # the first start on a machine compiles the simulation kernel
_SETTLE_S = 1.0

Show = Callable[[dict[str, Any]], None]


def wall_clock_runs(rig: Path, requests: list[dict[str, Any]], out: Path, show: Show) -> list[Path]:
    """Every request in a daemon of its own, so that no run starts with what the one before left swinging. One log a request."""
    logs = []
    for request in requests:
        with _daemon(rig, out) as client:
            logs.append(_one_run(client, request, show))
    return logs


def _one_run(client: Client, request: dict[str, Any], show: Show) -> Path:
    """Release the e-stop, which starts latched; arm, run, disarm: arming begins a new recording, so the run has a log of its own."""
    client.call("reset")
    client.call("arm")
    _until_mode(client, "holding", show)
    run = client.call("start", **request)
    result = wait_for(client, run["run"], show)
    log = Path(client.call("status")["log"]["path"])
    client.call("disarm")
    _until_mode(client, "disarmed", show)
    if result["validity"] != "valid":
        raise DaemonError("a demo run is not valid", value=result.get("reason", ""), where=str(log), next_step="See `longreach log info`.")
    return log


def _until_mode(client: Client, mode: str, show: Show) -> None:
    """Wait for a mode; the limit is generous because arming includes settling."""
    limit = time.monotonic() + 10.0
    while time.monotonic() < limit:
        status = client.call("status")
        show(status)
        if status["mode"] == mode:
            return
        time.sleep(0.05)
    raise DaemonError(
        "the daemon did not change its mode", value=status["mode"], limit=f"{mode} within 10 s", next_step="Run `longreach why`."
    )


@contextmanager
def _daemon(rig: Path, out: Path) -> Iterator[Client]:
    """A daemon with a private runtime directory, stopped as systemd would stop it."""
    with tempfile.TemporaryDirectory(prefix="longreach-demo-") as runtime:
        socket = Path(runtime) / "longreach.sock"
        journal = out / "longreachd.txt"
        with journal.open("ab") as output:
            process = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    "daemon.supervisor",
                    str(rig),
                    "--runtime-dir",
                    runtime,
                    "--socket",
                    str(socket),
                    "--log-dir",
                    str(out),
                ],
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**os.environ, "PYTHONUNBUFFERED": "1"},
            )
        try:
            with _wait_for_socket(socket, process, journal) as client:
                yield client
        finally:
            process.terminate()
            process.wait(timeout=20)


def _wait_for_socket(socket: Path, process: subprocess.Popen[bytes], journal: Path) -> Client:
    limit = time.monotonic() + _START_LIMIT_S
    while time.monotonic() < limit:
        if process.poll() is not None:
            raise DaemonError("the daemon ended while starting", value=process.returncode, where=str(journal), next_step=_tail(journal))
        try:
            client = Client(socket)
            client.call("status")
            return client
        except DaemonError:
            time.sleep(0.1)
    raise DaemonError("the daemon did not answer", limit=_START_LIMIT_S, unit="s", where=str(socket), next_step=_tail(journal))


def _tail(journal: Path) -> str:
    return "Its last words: " + " | ".join(journal.read_text(errors="replace").splitlines()[-3:])
