"""Soak: the daemon on the wall clock through a long maneuver, and in between bursts of an idle loop with the same clock and no work.

    python -m benchmarks.loop.soak [--minutes 10] [--rig ornl_testbed] [--out DIR]

The idle loop says what the computer itself costs: overruns that it has too are not the daemon's. Prints cycles present in the log,
drops, overruns and lateness of both, log volume and growth of memory. Exit status 1 when cycles are missing or were dropped.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from config.errors import DaemonError
from config.loading.load import load_rig
from config.schema.rig import Loop
from daemon.cycle.clock import WallClock
from daemon.cycle.overrun import PHASES, OverrunPolicy
from daemon.cycle.timing import WORDS, Timing
from daemon.host.realtime import request_realtime
from daemon.server.protocol import Client
from recording.files.reader import Log, read_log

BURST_S = 10.0
PAUSE_S = 20.0
WARM_UP_S = 20.0  # memory is compared from here on
LINE_S = 18.3  # one repeat of the paper's line
PHASES_US = {"read_us": " (with the simulated rig's step)", "compute_us": " (wanted: 60, 120)", "write_us": ""}


@dataclass
class Idle:
    """What the idle bursts have seen."""

    cycles: int = 0
    overruns: int = 0
    missed: int = 0
    late_p50_us: list[float] = field(default_factory=list)
    late_p99_us: list[float] = field(default_factory=list)
    late_max_us: float = 0.0

    def add(self, burst: dict[str, Any]) -> None:
        self.cycles += burst["cycles"]
        self.overruns += burst["overruns"]
        self.missed += burst["missed"]
        self.late_p50_us.append(burst["late_p50_us"])
        self.late_p99_us.append(burst["late_p99_us"])
        self.late_max_us = max(self.late_max_us, burst["late_max_us"])


@dataclass
class SoakSeen:
    """Everything the soak has seen: logs, idle bursts, memory of every process in bytes, faults."""

    logs: list[Path] = field(default_factory=list)
    idle: Idle = field(default_factory=Idle)
    memory: dict[str, list[int]] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)


def idle_burst(loop: Loop, seconds: float) -> dict[str, Any]:
    """The daemon's clock, overrun policy and priority around no work at all."""
    request_realtime(loop)
    period_ns = round(1e9 / loop.rate_Hz)
    clock, policy, timing = WallClock(loop.spin_s, 1.0 / loop.rate_Hz), OverrunPolicy(period_ns, loop.overruns), Timing([0] * WORDS)
    deadline, phases, cycles = clock.now_ns() + period_ns, [0] * len(PHASES), 0
    last = deadline + round(seconds * 1e9)
    while deadline < last:
        started = clock.wait_until(deadline)
        timing.count(0, (started - deadline) * 1e-3)
        deadline = policy.next_deadline(deadline, clock.now_ns(), phases)
        cycles += 1
    late = {f"late_p{percent}_us": timing.percentile_us("late", percent) for percent in (50, 99)}
    late["late_max_us"] = timing.largest_us("late")
    return {"cycles": cycles, "overruns": policy.overruns, "missed": policy.missed_periods, **late}


def soak(rig: str, minutes: float, out: Path) -> int:
    with tempfile.TemporaryDirectory(prefix="longreach-soak-") as runtime:
        command = [sys.executable, "-m", "daemon.processes.supervisor", rig, "--runtime-dir", runtime, "--log-dir", str(out)]
        daemon = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            with _connected(Path(runtime) / "longreach.sock", daemon) as client:
                seen = _drive(client, daemon.pid, rig, 60.0 * minutes)
        finally:
            daemon.terminate()
            daemon.wait(30)
    return _report(seen)


def _connected(socket: Path, daemon: subprocess.Popen[bytes]) -> Client:
    while daemon.poll() is None:
        try:
            return Client(socket)
        except DaemonError:
            time.sleep(0.1)
    raise DaemonError("the daemon ended while starting", value=daemon.returncode)


def _drive(client: Client, pid: int, rig: str, seconds: float) -> SoakSeen:
    """The paper's line over and over, armed again after a fault; idle bursts meanwhile; resident memory of every process."""
    seen = SoakSeen()
    began, next_burst = time.monotonic(), time.monotonic() + PAUSE_S
    while (elapsed := time.monotonic() - began) < seconds:
        status = client.call("status")
        if status["mode"] in ("disarmed", "fault"):
            if status["fault"]:
                seen.faults.append(status["fault"]["text"])
            seen.logs.append(_start(client, seconds - elapsed))
        time.sleep(1.0)
        if elapsed > WARM_UP_S:
            for name, resident in _resident(pid).items():
                seen.memory.setdefault(name, []).append(resident)
        if time.monotonic() > next_burst:
            burst = [sys.executable, "-m", "benchmarks.loop.soak", "--rig", rig, "--idle-burst", str(BURST_S)]
            seen.idle.add(json.loads(subprocess.run(burst, capture_output=True, check=True).stdout))
            next_burst = time.monotonic() + PAUSE_S
    client.call("disarm")
    return seen


def _start(client: Client, seconds: float) -> Path:
    """Arm and start; the log of this recording."""
    client.call("reset")
    client.call("arm")
    shaper = {"kind": "adaptive", "joints": ["rotary"]}
    repeat = max(1, ceil(seconds / LINE_S))
    client.call("start", maneuver={"name": "paper_line"}, shaper=shaper, repeat=repeat, approach=True, countdown_s=0.0)
    return Path(client.call("status")["log"]["path"])


def _resident(supervisor: int) -> dict[str, int]:
    """Bytes of every process of the daemon, from /proc."""
    found = {"supervisor": _bytes(supervisor)}
    for task in Path(f"/proc/{supervisor}/task").iterdir():
        for child in (task / "children").read_text().split():
            words = Path(f"/proc/{child}/cmdline").read_bytes().split(b"\0")
            found[words[words.index(b"-m") + 1].decode()] = _bytes(int(child))
    return found


def _bytes(pid: int) -> int:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def _report(seen: SoakSeen) -> int:
    logs = [read_log(path) for path in seen.logs]
    closings = [log.metadata.get("closing", {}) for log in logs]
    cycles = sum(log.cycles for log in logs)
    absent = sum(int(np.sum(np.diff(log.columns["cycle"].astype(np.int64)) - 1)) for log in logs)
    seconds = sum(float(log.columns["t_s"][-1] - log.columns["t_s"][0]) for log in logs)
    drops = sum(int(closing["drops"]) for closing in closings)
    print(f"{len(logs)} recordings, {cycles} cycles in them, absent {absent}, dropped {drops}, over {seconds:.1f} s")
    _beside_idle(logs, closings, cycles, seen.idle)
    for name, wanted in PHASES_US.items():
        took_us = np.concatenate([log.columns[name] for log in logs])
        print(f"{name + ' p50, p99' + wanted:44}{np.percentile(took_us, 50):8.1f}{np.percentile(took_us, 99):8.1f}")
    for number, closing in enumerate(closings, 1):
        work = ", ".join(f"{key} {closing[f'work_us_{key}']}" for key in ("p50", "p99", "max"))
        print(f"recording {number}: culprits {closing['overrun_culprits']}; grade {closing['grade']}; work per cycle, us: {work}")
    size = sum(path.stat().st_size for path in seen.logs) / 1e6
    print(f"log: {size:.1f} MB, {size / seconds:.4f} MB/s")
    for name, sizes in seen.memory.items():
        print(f"memory of {name}: {sizes[0] / 1e6:.1f} MB, grew by {(sizes[-1] - sizes[0]) / 1e6:+.2f} MB")
    for fault in seen.faults:
        print(f"fault: {fault}")
    return 1 if absent or drops else 0


def _beside_idle(logs: list[Log], closings: list[dict[str, Any]], cycles: int, idle: Idle) -> None:
    """The table of what was late, the daemon beside the loop without work."""
    overruns, missed = (sum(int(closing[key]) for closing in closings) for key in ("overruns", "missed_periods"))
    per = 1e5 / max(1, cycles), 1e5 / max(1, idle.cycles)
    late_us = np.concatenate([log.columns["late_us"] for log in logs])
    print(f"{'':28}{'daemon':>12}{'idle loop':>12}")
    print(f"{'cycles':28}{cycles:12}{idle.cycles:12}")
    print(f"{'overruns per 100 000':28}{overruns * per[0]:12.1f}{idle.overruns * per[1]:12.1f}")
    print(f"{'missed periods per 100 000':28}{missed * per[0]:12.1f}{idle.missed * per[1]:12.1f}")
    for percent, bursts in ((50, idle.late_p50_us), (99, idle.late_p99_us)):
        print(f"{f'late p{percent}, us (idle: median)':28}{np.percentile(late_us, percent):12.2f}{_median(bursts):12.2f}")
    print(f"{'latest, ms':28}{late_us.max() * 1e-3:12.2f}{idle.late_max_us * 1e-3:12.2f}")


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else float("nan")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--rig", default="ornl_testbed")
    parser.add_argument("--out", type=Path, default=Path("soak"))
    parser.add_argument("--idle-burst", type=float, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.idle_burst:
        print(json.dumps(idle_burst(load_rig(arguments.rig).rig.loop, arguments.idle_burst)))
        return 0
    return soak(arguments.rig, arguments.minutes, arguments.out)


if __name__ == "__main__":
    sys.exit(main())
