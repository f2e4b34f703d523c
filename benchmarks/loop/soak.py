"""Soak: the daemon on the wall clock through long maneuvers, and in between bursts of an idle loop with the same clock and no work.

    python -m benchmarks.loop.soak [--minutes 10] [--rig ornl_testbed] [--set KEY=VALUE] [--out DIR]

The idle loop says what the computer itself costs: overruns that it has too are not the daemon's. Prints cycles present in the log,
drops, overruns and lateness of both, log volume and growth of memory: pages of every process, and allocated blocks of the loop's, which
counts them itself when it is asked to and times the handing over of every record. Exit status 1 when cycles are missing or were dropped.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from math import ceil
from pathlib import Path
from typing import Any

from benchmarks.loop.soak_report import SoakSeen, report
from config.errors import DaemonError
from config.loading.load import apply_overrides, load_rig
from config.schema.rig import Loop
from daemon.cycle.clock import WallClock
from daemon.cycle.overrun import PHASES, OverrunPolicy
from daemon.cycle.timing import WORDS, Timing
from daemon.host.realtime import request_realtime
from daemon.server.protocol import Client

BURST_S = 10.0
PAUSE_S = 20.0
WARM_UP_S = 20.0  # memory is compared from here on
LINE_S = 18.3  # one repeat of the paper's line
RUN_S = 600.0  # the longest run: a recording of each is read whole
COUNTED = Path(__file__).parent / "counted"
COUNT_EVERY_S = 10.0


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


def soak(text: str, minutes: float, out: Path) -> int:
    """`text`: the rig file."""
    with tempfile.TemporaryDirectory(prefix="longreach-soak-") as place:
        rig, counts = Path(place) / "rig.yaml", Path(place) / "counts.txt"
        rig.write_text(text)
        command = [sys.executable, "-m", "daemon.processes.supervisor", str(rig), "--runtime-dir", place, "--log-dir", str(out)]
        counted = {"PYTHONPATH": f"{COUNTED}{os.pathsep}{COUNTED.parents[2]}", "LONGREACH_COUNTS": str(counts)}
        out.mkdir(parents=True, exist_ok=True)
        with (out / "journal.txt").open("wb") as journal:
            daemon = subprocess.Popen(command, stdout=journal, stderr=subprocess.STDOUT, env={**os.environ, **counted})
        try:
            with _connected(Path(place) / "longreach.sock", daemon, out) as client:
                seen = _drive(client, daemon.pid, rig, 60.0 * minutes)
        finally:
            daemon.terminate()
            daemon.wait(30)
        seen.take_counts(counts)
    return report(seen)


def _connected(socket: Path, daemon: subprocess.Popen[bytes], out: Path) -> Client:
    while daemon.poll() is None:
        try:
            return Client(socket)
        except DaemonError:
            time.sleep(0.1)
    raise DaemonError("the daemon ended while starting", value=daemon.returncode, next_step=f"See {out / 'journal.txt'}.")


def _drive(client: Client, pid: int, rig: Path, seconds: float) -> SoakSeen:
    """The paper's line over and over, armed again after each run and after a fault; idle bursts meanwhile; memory of every process."""
    seen, repeat = SoakSeen(), max(1, ceil(min(seconds, RUN_S) / LINE_S))
    began, next_count, next_burst = time.monotonic(), WARM_UP_S, PAUSE_S
    while (elapsed := time.monotonic() - began) < seconds:
        _keep_moving(client, seen, repeat)
        time.sleep(1.0)
        if elapsed > next_count:
            _count_memory(pid, seen)
            next_count = elapsed + COUNT_EVERY_S
        if elapsed > next_burst:
            burst = [sys.executable, "-m", "benchmarks.loop.soak", "--rig", str(rig), "--idle-burst", str(BURST_S)]
            seen.idle.add(json.loads(subprocess.run(burst, capture_output=True, check=True).stdout))
            next_burst = elapsed + BURST_S + PAUSE_S
    client.call("disarm")
    return seen


def _keep_moving(client: Client, seen: SoakSeen, repeat: int) -> None:
    """Arm and start where nothing moves any more."""
    status = client.call("status")
    if status["mode"] == "holding":  # the run is over
        client.call("disarm")
    elif status["mode"] in ("disarmed", "fault"):
        if status["fault"]:
            seen.faults.append(status["fault"]["text"])
        with suppress(DaemonError):  # what refused it on a busy machine has passed a second later
            seen.logs.append(_start(client, repeat))


def _start(client: Client, repeat: int) -> Path:
    """The log of the recording that begins."""
    client.call("reset")
    client.call("arm")
    shaper = {"kind": "adaptive", "joints": ["rotary"]}
    client.call("start", maneuver={"name": "paper_line"}, shaper=shaper, repeat=repeat, approach=True, countdown_s=0.0)
    return Path(client.call("status")["log"]["path"])


def _count_memory(pid: int, seen: SoakSeen) -> None:
    for name, process in _processes(pid).items():
        seen.memory.setdefault(name, []).append(_bytes(process))
        if name == "daemon.processes.control_process":
            os.kill(process, signal.SIGUSR1)


def _processes(supervisor: int) -> dict[str, int]:
    """Every process of the daemon, from /proc."""
    found = {"supervisor": supervisor}
    for task in Path(f"/proc/{supervisor}/task").iterdir():
        for child in (task / "children").read_text().split():
            words = Path(f"/proc/{child}/cmdline").read_bytes().split(b"\0")
            found[words[words.index(b"-m") + 1].decode()] = int(child)
    return found


def _bytes(pid: int) -> int:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--rig", default="ornl_testbed")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="in the rig file, such as loop.rate='2 kHz'")
    parser.add_argument("--out", type=Path, default=Path("soak"))
    parser.add_argument("--idle-burst", type=float, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.idle_burst:
        print(json.dumps(idle_burst(load_rig(arguments.rig).rig.loop, arguments.idle_burst)))
        return 0
    return soak(apply_overrides(load_rig(arguments.rig).text, arguments.set), arguments.minutes, arguments.out)


if __name__ == "__main__":
    sys.exit(main())
