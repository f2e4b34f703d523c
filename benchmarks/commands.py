"""How fast commands answer: start-up of each, of the daemon, and `longreach estop` from the shell to safe outputs under load.

    python -m benchmarks.commands [--runs 5] [--estops 20] [--json] [--page docs/results/commands.md]

Wall time is what an operator waits, processor time what the machine works for it: on a busy machine only the latter compares. The load
is one process a processor that never sleeps, beside the daemon that holds the arm; safe is what the valves' register says, seen from
outside.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path

from daemon.cli.commands import COMMANDS
from daemon.faults.benches.daemon_process import DaemonProcess, hold
from daemon.faults.benches.register_watch import RegisterWatch
from daemon.host import host_facts
from daemon.host.busy_processors import busy_processors

LONGREACH = [sys.executable, "-m", "daemon.cli.main"]
BESIDE_DAEMON = ("status", "why", "events", "maneuvers", "stop", "disarm")
LOOK_S = 0.0005  # between looks at the valves
LONGEST_S = 10.0


@dataclass(frozen=True, slots=True)
class Row:
    """What was measured of one thing, run by run; seconds. Empty: not the point of this row."""

    what: str
    wall_s: Sequence[float]
    processor_s: Sequence[float] = ()

    def text(self) -> str:
        own = f"{median(self.processor_s):10.3f}" if self.processor_s else " " * 10
        wall = (median(self.wall_s), quantile(self.wall_s, 0.9), max(self.wall_s)) if self.wall_s else ()
        return f"{self.what:36}{own}{''.join(f'{each:10.3f}' for each in wall)}"


def quantile(values: Sequence[float], share: float) -> float:
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def median(values: Sequence[float]) -> float:
    return quantile(values, 0.5)


def timed(words: Sequence[str]) -> tuple[float, float]:
    """Wall and processor time of one command, in s; whether it is refused does not matter."""
    begun = time.perf_counter()
    process = subprocess.Popen([*LONGREACH, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return time.perf_counter() - begun, used.ru_utime + used.ru_stime


def commands(runs: int, words: Sequence[Sequence[str]]) -> Iterator[Row]:
    """Each command `runs` times, by turns, so that a bad second of the machine does not meet one command alone."""
    found: list[list[tuple[float, float]]] = [[] for _ in words]
    for _ in range(runs):
        for number, each in enumerate(words):
            found[number].append(timed(each))
    for each, times in zip(words, found, strict=True):
        name = " ".join(each[2:] if each[0] == "--socket" else each)
        yield Row(f"longreach {name}", [wall for wall, _ in times], [processor for _, processor in times])


def daemon_starts(runs: int) -> Iterator[Row]:
    """From the command to READY with the simulated test bed; a first start, which may compile, is not counted."""
    walls, shares = [], []
    for number in range(runs + 1):
        with tempfile.TemporaryDirectory() as directory:
            wall, used = _daemon_start(Path(directory))
        if number:
            walls.append(wall)
            shares.append(used)
    yield Row("longreachd to READY", walls, [sum(used.values()) for used in shares])
    for name in shares[0]:
        yield Row(f"  of it {name}", (), [used[name] for used in shares])


def _daemon_start(directory: Path) -> tuple[float, dict[str, float]]:
    places = ["--runtime-dir", str(directory / "run"), "--log-dir", str(directory / "logs")]
    begun = time.perf_counter()
    command = [sys.executable, "-m", "daemon.processes.supervisor", "ornl_testbed", *places]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()  # "... is disarmed": READY
        wall = time.perf_counter() - begun
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        used = {"supervisor": _processor_s(process.pid)} | {_name(child): _processor_s(int(child)) for child in children}
        process.terminate()
    return wall, used


def _processor_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _name(pid: str) -> str:
    module = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")[2].decode()
    return module.rpartition(".")[2].removesuffix("_process")


def estops(daemon: DaemonProcess, count: int, name: str) -> Row:
    """From the start of `longreach estop` to safe outputs, the arm held before; then a reset."""
    client = daemon.connect()
    found = []
    for _ in range(count):
        hold(client)
        watch = RegisterWatch(daemon.register(), time.monotonic_ns())
        with subprocess.Popen([*LONGREACH, "--socket", str(daemon.socket), "estop"], stdout=subprocess.DEVNULL) as process:
            _until(lambda watch=watch: _is_safe(watch))  # type: ignore[misc]
            process.wait()
        found.append(watch.safe_after_ms * 1e-3)
        client.call("reset")
    return Row(name, found)


def _is_safe(watch: RegisterWatch) -> bool:
    watch.update(time.monotonic_ns())
    return watch.safe_for_ms(time.monotonic_ns()) > 0 and not watch.timed_out


def _until(condition: Callable[[], bool]) -> None:
    limit = time.monotonic() + LONGEST_S
    while not condition():
        if time.monotonic() > limit:
            raise TimeoutError(f"the outputs were not safe after {LONGEST_S:g} s")
        time.sleep(LOOK_S)


def measure(runs: int, count: int) -> Iterator[Row]:
    """Every row, as soon as it is known."""
    yield from commands(runs, [(command.name, "--help") for command in COMMANDS])
    yield from daemon_starts(runs)
    with tempfile.TemporaryDirectory() as directory, DaemonProcess(Path(directory)) as daemon:
        daemon.connect()
        yield from commands(runs, [("--socket", str(daemon.socket), name) for name in BESIDE_DAEMON])
        yield estops(daemon, count, "estop to safe outputs")
        with busy_processors():
            yield estops(daemon, count, "estop to safe outputs, under load")


HEAD = f"{'s':36}{'processor':>10}{'median':>10}{'p90':>10}{'worst':>10}"
PAGE = """# Results: how fast commands answer

`python -m benchmarks.commands --runs {runs} --estops {estops} --page docs/results/commands.md`, {day}
({host}; {cpus} processors, {load} processes wanted them before it began). The wall times
hold what else the machine did; processor time is the median.

```text
{table}
```

Wanted: `status` within 0.25 s beside an idle daemon, READY within 3 s, `estop` to safe outputs within 0.1 s, on
a machine with nothing else to do. What an operator types under stress imports the standard library alone, which
`tests/daemon/cli/test_command_imports.py` holds; what the daemon's processes load,
`tests/daemon/processes/test_start_imports.py`.

READY took 3.3 s of processor time (supervisor 0.75, recorder 0.65, control 1.9 s; 533f84d, same machine and
day) before units stood in a table, YAML was read by libyaml and the recorder did without the rig.
"""


def page(rows: Sequence[Row], arguments: argparse.Namespace, load: float) -> str:
    host = host_facts.host()
    facts = {"host": f"{host['host_cpu']}, Python {host['host_python']}", "cpus": host["host_cpus"], "load": f"{load:.1f}"}
    counts = {"runs": arguments.runs, "estops": arguments.estops, "day": f"{datetime.now(UTC):%Y-%m-%d}"}
    return PAGE.format(**facts, **counts, table="\n".join([HEAD, *(row.text() for row in rows)]))


def main(argv: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=5, metavar="N", help="of each command (default 5)")
    parser.add_argument("--estops", type=int, default=20, metavar="N", help="e-stops, idle and under load (default 20 each)")
    parser.add_argument("--json", action="store_true", help="every single time, in s")
    parser.add_argument("--page", type=Path, help="write a page for docs/results")
    arguments = parser.parse_args(argv)
    load = os.getloadavg()[0]
    rows = []
    if not arguments.json:
        print(HEAD, flush=True)
    for row in measure(arguments.runs, arguments.estops):
        rows.append(row)
        if not arguments.json:
            print(row.text(), flush=True)
    if arguments.json:
        print(json.dumps([asdict(row) for row in rows]))
    if arguments.page:
        arguments.page.write_text(page(rows, arguments, load), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
