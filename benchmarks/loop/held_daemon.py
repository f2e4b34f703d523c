"""longreachd in processes of its own, the arm held: with the simulated rig in it, and over CAN with the twin in a network namespace."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.loop.periods import figures
from config.errors import DaemonError
from daemon.faults.benches.commissioning import commission
from daemon.faults.benches.daemon_process import DaemonProcess, hold
from daemon.faults.benches.twin_process import PATIENCE, TwinProcess, multicast_rig, patient
from recording.files.reader import Log, read_log
from sim_backend.twin.network_namespace import NetworkNamespace

Load = Callable[[], AbstractContextManager[None]]
_SETTLE_S = 0.5
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def in_process(seconds: float, load: Load, period_us: float) -> dict[str, float]:
    """The testbed's rig file as it is, but for the patience with a shared machine."""
    with (
        TemporaryDirectory(prefix="longreach-bench-") as place,
        DaemonProcess(Path(place), PATIENCE[:2]) as daemon,
        daemon.connect() as client,
    ):
        hold(client)
        return _held(daemon, Path(place) / "logs", seconds, load, period_us)


def over_can(seconds: float, load: Load, period_us: float) -> dict[str, float]:
    """Encoders, valves and the tip's sensors behind udp_multicast. Needs root; twin and loop have a processor each."""
    rig = patient(multicast_rig())
    with ExitStack() as stack:
        namespace = NetworkNamespace(f"longreach-jitter-{os.getpid()}")
        stack.callback(namespace.delete)
        place = Path(stack.enter_context(TemporaryDirectory(prefix="longreach-bench-")))
        (place / "daemon").mkdir()
        twin = stack.enter_context(TwinProcess(namespace, place, rig))
        daemon = stack.enter_context(DaemonProcess(place / "daemon", text=rig, prefix=namespace.prefix))
        with daemon.connect() as client:
            commission(client, twin.control)
            return _held(daemon, place / "daemon" / "logs", seconds, load, period_us)


def recording(directory: Path, limit_s: float = 10.0) -> Log:
    """The newest recording of armed time, once it is whole. DaemonError when there is none."""
    limit = time.monotonic() + limit_s
    while time.monotonic() < limit:
        paths = sorted(directory.glob("*.mcap"), key=lambda path: path.stat().st_mtime_ns)
        armed = [path for path in paths if not path.stem.endswith("-standby")]
        if armed and paths[-1] != armed[-1]:  # a standby recording is being written again
            time.sleep(0.5)  # the last chunk
            return read_log(armed[-1])
        time.sleep(0.02)
    raise DaemonError("no recording", where=str(directory))


def cpu_s(pid: int) -> float:
    """Processor time of a process."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS_PER_S


def _held(daemon: DaemonProcess, logs: Path, seconds: float, load: Load, period_us: float) -> dict[str, float]:
    """The cycles of `seconds` from now; `processor`: share of one that the control process took, `read`: that of its reading alone."""
    loop = daemon.pid("control")
    with daemon.connect() as client:
        with load():
            time.sleep(_SETTLE_S)
            first, before, began = client.call("status")["cycle"], cpu_s(loop), time.monotonic()
            time.sleep(seconds)
            status, spent, took_s = client.call("status"), cpu_s(loop) - before, time.monotonic() - began
        if status["mode"] != "holding":
            raise DaemonError("the arm was not held to the end", value=str(status["fault"]))
        client.call("disarm")
        columns = recording(logs).columns
    chosen = (columns["cycle"] >= first) & (columns["cycle"] <= status["cycle"])
    began_us = 1e6 * columns["t_s"][chosen] + columns["late_us"][chosen]
    shares = {"processor": spent / took_s, "read": float(columns["read_us"][chosen].sum()) * 1e-6 / took_s}
    return figures(began_us.tolist(), period_us) | shares
