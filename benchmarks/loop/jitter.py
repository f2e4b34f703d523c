"""Period jitter of the daemon's clock beside cyclictest and LinuxCNC's servo thread, in short runs that take turns: medians of runs and of
their ratios.

    python -m benchmarks.loop.jitter [--pairs 6] [--seconds 4] [--load] [--json]

Each turn runs the clock with a spin of fixed length, the clock as it is (the spin follows the wake-ups), cyclictest at the same priority,
and LinuxCNC at its own (98), one after the other. A shared machine has good and bad minutes, so only ratios within a turn mean anything.
`--load` keeps stress-ng on every processor. cyclictest (package rt-tests) and LinuxCNC (linuxcnc-uspace) are left out where they are not
installed.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from statistics import median

import numpy as np

from benchmarks.loop import linuxcnc
from config.schema.rig import Loop
from daemon.cycle.clock import AdaptiveSpin, WallClock
from daemon.host.realtime import request_realtime

PERIOD_NS = 1_000_000
WORK_NS = 120_000  # of a cycle, as the controller with two joints takes
FIGURES = ("p50", "p99", "p99.9", "late")
OWN = ("fixed spin", "daemon's clock")
HIGH = 1.5
MISSING = {"cyclictest": "cyclictest: not installed (apt-get install rt-tests)", "LinuxCNC": linuxcnc.MISSING}


def figures(late_us: list[float]) -> dict[str, float]:
    """Of the lateness of each cycle in us: quantiles of the change of the period, and cycles more than a period late."""
    jitter = np.abs(np.diff(late_us))
    found = dict(zip(FIGURES[:3], np.quantile(jitter, (0.5, 0.99, 0.999)).tolist(), strict=True))
    return found | {"late": float(np.sum(np.asarray(late_us) > PERIOD_NS / 1e3))}


def own_clock(adaptive: bool, seconds: float) -> dict[str, float]:
    """The daemon's clock and requests for real time around a fixed amount of work."""
    request_realtime(Loop())
    if not adaptive:
        AdaptiveSpin.MOST_OF_PERIOD = 0.0
    clock = WallClock(Loop().spin_s, PERIOD_NS * 1e-9)
    count = round(seconds * 1e9 / PERIOD_NS)
    late, first = [0.0] * count, clock.now_ns() + 10 * PERIOD_NS
    for cycle in range(count):
        deadline = first + cycle * PERIOD_NS
        now = clock.wait_until(deadline)
        late[cycle] = (now - deadline) * 1e-3
        while clock.now_ns() < now + WORK_NS:
            pass
    return figures(late)


def _own_process(name: str, seconds: float) -> dict[str, float]:
    one = [sys.executable, "-m", "benchmarks.loop.jitter", "--one", name, "--seconds", str(seconds)]
    return dict(json.loads(subprocess.run(one, capture_output=True, text=True, check=True).stdout))


def cyclictest(seconds: float) -> dict[str, float]:
    """Its lateness cycle by cycle, as it prints it."""
    loops = round(seconds * 1e9 / PERIOD_NS)
    command = ["cyclictest", "--mlockall", "--priority", str(Loop().priority), "--interval", str(PERIOD_NS // 1000), "--verbose"]
    done = subprocess.run([*command, "--loops", str(loops)], capture_output=True, text=True, check=True)
    rows = [line.split(":") for line in done.stdout.splitlines() if line.count(":") == 2 and line.strip()[0].isdigit()]
    return figures([float(row[2]) for row in rows])


@contextmanager
def loaded(wanted: bool) -> Iterator[None]:
    if not wanted:
        yield
        return
    with subprocess.Popen(["stress-ng", "--cpu", "0", "--vm", "1", "--switch", "1", "--quiet"], stdout=subprocess.DEVNULL) as load:
        try:
            yield
        finally:
            load.terminate()


def turns(pairs: int, seconds: float) -> dict[str, list[dict[str, float]]]:
    """Every program once a turn, each in a process of its own."""
    ways: dict[str, Callable[[], dict[str, float]]] = {name: partial(_own_process, name, seconds) for name in OWN}
    if shutil.which("cyclictest"):
        ways["cyclictest"] = lambda: cyclictest(seconds)
    if linuxcnc.is_here():
        ways["LinuxCNC"] = lambda: figures(linuxcnc.servo_thread(seconds, PERIOD_NS))
    runs: dict[str, list[dict[str, float]]] = {name: [] for name in ways}
    for turn in range(pairs):
        for name, way in ways.items():
            runs[name].append(way())
        seen = ", ".join(f"{name} {found[-1]['p99']:.1f} us" for name, found in runs.items())
        print(f"turn {turn + 1} of {pairs}, p99: {seen}", file=sys.stderr, flush=True)
    return runs


def summary(runs: dict[str, list[dict[str, float]]]) -> list[str]:
    """A line a program, then the ratios to the daemon's clock turn by turn."""
    lines = [f"{'period jitter (us), median of turns':38}{'p50':>9}{'p99':>9}{'p99.9':>9}{'> 1 ms late':>13}"]
    for name, found in runs.items():
        lines.append(f"{name:38}" + "".join(f"{median(run[key] for run in found):9.1f}" for key in FIGURES[:3])
                     + f"{median(run['late'] for run in found):13.0f}")  # fmt: skip
    own = runs["daemon's clock"]
    for name in (name for name in runs if name != "daemon's clock"):
        for key in ("p99", "p99.9"):
            ratios = sorted((a[key] + 0.1) / (b[key] + 0.1) for a, b in zip(own, runs[name], strict=True))
            above = sum(ratio > HIGH for ratio in ratios)
            lines.append(
                f"{key} of the daemon's clock over {name}: median {median(ratios):.2f}, {ratios[0]:.2f} to {ratios[-1]:.2f}; "
                f"above {HIGH:g} in {above} of {len(ratios)} turns"
            )
    return lines + [missing for name, missing in MISSING.items() if name not in runs]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--pairs", type=int, default=6, metavar="N", help="turns (default 6)")
    parser.add_argument("--seconds", type=float, default=4.0, metavar="S", help="of each run (default 4)")
    parser.add_argument("--load", action="store_true", help="stress-ng on every processor")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--one", choices=OWN, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(own_clock(arguments.one != OWN[0], arguments.seconds)))
        return 0
    with loaded(arguments.load):
        runs = turns(arguments.pairs, arguments.seconds)
    print(json.dumps(runs) if arguments.json else "\n".join(summary(runs)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
