"""Period jitter of the loop beside cyclictest and LinuxCNC's servo thread, in short runs that take turns: medians of runs and of their
ratios.

    python -m benchmarks.loop.jitter [--pairs 6] [--seconds 4] [--load [0|1]] [--programs ...] [--json]
    python -m benchmarks.loop.jitter --append turns.jsonl --pairs 3     a batch more; many of them over hours say most
    python -m benchmarks.loop.jitter --summary turns.jsonl

Each turn runs the daemon's clock with a fixed amount of work, longreachd holding the simulated rig, longreachd holding the twin over CAN,
cyclictest at the same priority, and LinuxCNC at its own (98), one after the other. A shared machine has good and bad minutes, so only
ratios within a turn mean anything. `--load` keeps stress-ng on every processor, or on one. What cannot run here is left out: cyclictest
(package rt-tests), LinuxCNC (linuxcnc-uspace), CAN (root, for a network namespace).
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.loop import held_daemon, linuxcnc
from benchmarks.loop.jitter_table import table
from benchmarks.loop.periods import began_of_lateness, figures
from config.errors import LongreachError
from config.schema.rig import Loop
from daemon.cycle.clock import WallClock
from daemon.cycle.overrun import PHASES, OverrunPolicy
from daemon.host.realtime import request_realtime

PERIOD_NS = 1_000_000
PERIOD_US = PERIOD_NS * 1e-3
WORK_NS = 120_000  # of a cycle, as the controller with two joints takes
ALL = "all"
Load = Callable[[], AbstractContextManager[None]]
Program = Callable[[float, Load], dict[str, float]]


def own_clock(seconds: float, load: Load) -> dict[str, float]:
    """The daemon's clock, deadlines and requests for real time around a fixed amount of work; in a process of its own."""
    one = [sys.executable, "-m", "benchmarks.loop.jitter", "--clock", "--seconds", str(seconds)]
    with load():
        return dict(json.loads(subprocess.run(one, capture_output=True, text=True, check=True).stdout))


def clock_here(seconds: float) -> dict[str, float]:
    loop = Loop()
    request_realtime(loop)
    clock, policy, phases = WallClock(loop.spin_s, PERIOD_NS * 1e-9), OverrunPolicy(PERIOD_NS, loop.overruns), [0] * len(PHASES)
    count = round(seconds * 1e9 / PERIOD_NS)
    began, deadline = [0.0] * count, clock.now_ns() + 10 * PERIOD_NS
    for cycle in range(count):
        now = ended = clock.wait_until(deadline)
        began[cycle] = now * 1e-3
        while ended < now + WORK_NS:
            ended = clock.now_ns()
        deadline = policy.next_deadline(deadline, ended, phases)
    return figures(began, PERIOD_US)


def cyclictest(seconds: float, load: Load) -> dict[str, float]:
    """Its lateness cycle by cycle, as it prints it."""
    loops = round(seconds * 1e9 / PERIOD_NS)
    command = ["cyclictest", "--mlockall", "--priority", str(Loop().priority), "--interval", str(PERIOD_NS // 1000), "--verbose"]
    with load():
        done = subprocess.run([*command, "--loops", str(loops)], capture_output=True, text=True, check=True)
    rows = [line.split(":") for line in done.stdout.splitlines() if line.count(":") == 2 and line.strip()[0].isdigit()]
    return figures(began_of_lateness([float(row[2]) for row in rows], PERIOD_US), PERIOD_US)


def servo_thread(seconds: float, load: Load) -> dict[str, float]:
    with load():
        return figures(linuxcnc.servo_thread(seconds, PERIOD_NS), PERIOD_US)


PROGRAMS: dict[str, Program] = {
    "clock": own_clock,
    "longreachd": partial(held_daemon.in_process, period_us=PERIOD_US),
    "longreachd-can": partial(held_daemon.over_can, period_us=PERIOD_US),
    "cyclictest": cyclictest,
    "LinuxCNC": servo_thread,
}
MISSING = {
    "longreachd-can": "longreachd-can: needs root and ip (iproute2) for a network namespace",
    "cyclictest": "cyclictest: not installed (apt-get install rt-tests)",
    "LinuxCNC": linuxcnc.MISSING,
}


def can_run(name: str) -> bool:
    if name == "longreachd-can":
        return os.geteuid() == 0 and bool(shutil.which("ip"))
    return linuxcnc.is_here() if name == "LinuxCNC" else name != "cyclictest" or bool(shutil.which("cyclictest"))


@contextmanager
def loaded(processor: str | None) -> Iterator[None]:
    """stress-ng on one processor or on all of them; None: no load. It begins once a daemon has started: that takes minutes beside it."""
    if processor is None:
        yield
        return
    each = ["--cpu", "0"] if processor == ALL else ["--cpu", "1", "--taskset", processor]
    with subprocess.Popen(["stress-ng", *each, "--vm", "1", "--switch", "1", "--quiet"], stdout=subprocess.DEVNULL) as load:
        try:
            yield
        finally:
            load.terminate()


def turns(names: Sequence[str], pairs: int, seconds: float, load: str | None) -> Iterator[dict[str, Any]]:
    """Every program once a turn. A run that breaks off, as the daemon's does where the machine stands still for long, is told and left
    out."""
    for number in range(pairs):
        turn: dict[str, Any] = {"utc": f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S}", "load": load or "idle", "seconds": seconds}
        turn |= {"wanted_1_min": os.getloadavg()[0], "busy_beside": busy_share(), "runs": {}, "broken": {}}
        for name in names:
            try:
                turn["runs"][name] = PROGRAMS[name](seconds, partial(loaded, load))
            except (LongreachError, subprocess.SubprocessError, RuntimeError) as error:
                turn["broken"][name] = str(error).splitlines()[0][:200]
        seen = ", ".join(f"{name} {found['p99']:.1f} us" for name, found in turn["runs"].items())
        print(f"turn {number + 1} of {pairs}, p99: {seen} {turn['broken'] or ''}", file=sys.stderr, flush=True)
        yield turn


def busy_share(seconds: float = 0.5) -> float:
    """Share of all processors that others took just before a turn."""

    def idle_and_all() -> tuple[int, int]:
        ticks = [int(word) for word in Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]
        return ticks[3] + ticks[4], sum(ticks)

    idle, whole = idle_and_all()
    time.sleep(seconds)
    idle_after, whole_after = idle_and_all()
    return 1.0 - (idle_after - idle) / max(1, whole_after - whole)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--pairs", type=int, default=6, metavar="N", help="turns (default %(default)s)")
    parser.add_argument("--seconds", type=float, default=4.0, metavar="S", help="of each run (default %(default)g)")
    parser.add_argument("--load", nargs="?", const=ALL, metavar="PROCESSOR", help="stress-ng on every processor, or on this one")
    parser.add_argument("--programs", nargs="+", choices=tuple(PROGRAMS), default=tuple(PROGRAMS), help="these alone")
    parser.add_argument("--append", type=Path, metavar="FILE", help="each turn as a line of JSON at the end of a file")
    parser.add_argument("--summary", type=Path, metavar="FILE", help="run nothing: the table of what was appended")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--clock", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.clock:
        print(json.dumps(clock_here(arguments.seconds)))
        return 0
    if arguments.summary:
        print("\n".join(table([json.loads(line) for line in arguments.summary.read_text().splitlines()])))
        return 0
    names, seen = [name for name in arguments.programs if can_run(name)], []
    for turn in turns(names, arguments.pairs, arguments.seconds, arguments.load):
        seen.append(turn)
        if arguments.append:
            with arguments.append.open("a") as file:
                file.write(json.dumps(turn) + "\n")
    left_out = [MISSING[name] for name in arguments.programs if name not in names]
    print(json.dumps(seen) if arguments.json else "\n".join([*table(seen), *left_out]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
