"""A daemon of a command's own, on the wall clock, with a private runtime directory; it ends with the command."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from config.errors import DaemonError
from daemon.server.protocol import Client

JOURNAL = "longreachd.txt"
_START_LIMIT_S = 90.0  # the first start on a machine compiles the simulation kernel
_END_LIMIT_S = 20.0


@contextmanager
def private_daemon(rig: Path, out: Path) -> Iterator[Client]:
    """Its recordings and its words go to `out`; it is stopped as systemd would stop it. DaemonError when it does not start or end."""
    with tempfile.TemporaryDirectory(prefix="longreach-run-") as runtime:
        socket, journal = Path(runtime) / "longreach.sock", out / JOURNAL
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
