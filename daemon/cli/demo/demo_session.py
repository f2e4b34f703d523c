"""One run of the demo through a real daemon on the wall clock."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from config.errors import DaemonError
from daemon.cli.operate.motion_commands import wait_for
from daemon.server.protocol import Client
from recording.files.recordings import asked

_START_LIMIT_S = 90.0  # the first start on a machine compiles the simulation kernel
_END_LIMIT_S = 20.0
_MODE_LIMIT_S = 10.0

Show = Callable[[dict[str, Any]], None]


def wall_clock_run(rig: Path, request: Mapping[str, Any], out: Path, show: Show) -> Path:
    """A request in a daemon of its own, so that no run starts with what the one before left swinging. Returns its log.

    Raises DaemonError when the daemon does not start, does not arm in time, or the run does not end valid; refusals as `start`.
    """
    with _daemon(rig, out) as client:
        return _one_run(client, request, show)


def _one_run(client: Client, request: Mapping[str, Any], show: Show) -> Path:
    """Release the e-stop, which starts latched; arm, run, disarm: arming begins a new recording, so the run has a log of its own."""
    client.call("reset")
    client.call("arm")
    _until_mode(client, "holding", show)
    run = client.call("start", **request)
    result = wait_for(client, run["run"], show)
    log = Path(client.call("status")["log"]["path"])
    client.call("disarm")
    if result["validity"] != "valid":
        raise DaemonError(
            "a demo run is not valid",
            value=str(result.get("reason", "")).rstrip("."),
            where=str(log),
            next_step=f"See {asked('info', log)}.",
        )
    _until_mode(client, "disarmed", show)
    return log


def _until_mode(client: Client, mode: str, show: Show) -> None:
    """Wait for a mode; the limit is generous because arming includes settling."""
    limit = time.monotonic() + _MODE_LIMIT_S
    while time.monotonic() < limit:
        status = client.call("status")
        show(status)
        if status["mode"] == mode:
            return
        if status["mode"] == "fault":
            break
        time.sleep(0.05)
    fault = status.get("fault")
    raise DaemonError(
        "the daemon did not change its mode",
        value=f"{status['mode']}: {fault['text'].rstrip('.')}" if fault else status["mode"],
        limit=f"{mode} within {_MODE_LIMIT_S:g} s",
        next_step="See whether other work keeps this computer busy: `longreach host`.",
    )


@contextmanager
def _daemon(rig: Path, out: Path) -> Iterator[Client]:
    """A daemon with a private runtime directory, stopped as systemd would stop it."""
    with tempfile.TemporaryDirectory(prefix="longreach-demo-") as runtime:
        socket, journal = Path(runtime) / "longreach.sock", out / "longreachd.txt"
        places = ["--runtime-dir", runtime, "--socket", str(socket), "--log-dir", str(out)]
        with journal.open("ab") as output:
            process = subprocess.Popen(
                [sys.executable, "-m", "daemon.processes.supervisor", str(rig), *places],
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**os.environ, "PYTHONUNBUFFERED": "1"},
            )
        try:
            with _wait_for_socket(socket, process, journal) as client:
                yield client
        finally:
            end(process, _END_LIMIT_S)


def end(process: subprocess.Popen[bytes], limit_s: float) -> None:
    """Stop the daemon; one that a busy machine keeps from ending is killed, and its children end with it. DaemonError then."""
    process.terminate()
    try:
        process.wait(limit_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        advice = "Look for other work on this computer: `longreach host`."
        raise DaemonError("the daemon did not end in time", limit=f"{limit_s:g}", unit="s", next_step=advice) from None


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
