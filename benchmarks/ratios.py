"""Three ratios that a change of the code may make worse, two of them judged against a kept baseline: kernel over C, recorder over the
plain mcap writer; and, shown only, controller over a loop of fixed arithmetic, which a busy machine alone makes worse by half.

    python -m benchmarks.ratios                    shows them, and whether one has become worse (exit status 1)
    python -m benchmarks.ratios --write --runs 12  makes this processor's baseline of these runs; let the machine be busy and idle meanwhile

Both sides of a ratio take turns and only processor time counts, so a slow minute meets both. A run is a process of its own, since where
a process comes to lie in memory moves its ratios by some per cent. Judged is the median of a run's pairs. It is worse where it lies above
the baseline's median by more than half of the baseline's spread, the range of its runs' medians, and by more than a fifth. (The range of
all pairs is made by the worst single one.) What is worse is measured again, twice at most, and fails if it is worse each time.

The file keeps a baseline for each processor that one was written on. A processor without one is judged by the loosest limit of the others,
and then by as much more as two makers' processors were seen to differ. A baseline of another Python (3.11, 3.12) judges nothing.
"""

from __future__ import annotations

import argparse
import gc
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from math import nan
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks import recorder
from benchmarks.kernel.beside.c_version import CPlant
from config.loading.load import find, load_maneuver, load_rig
from config.schema.maneuver import maneuver_content
from config.whole_file import write_whole
from daemon.host.host_facts import host, software
from recording.format.layout import CycleLayout
from servo_control.controller import Controller
from servo_control.planning.planning import plan_run
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Inputs, Mode
from sim_backend.memory.layout import C
from sim_backend.plant import SimulatedRig

BASELINE = Path(__file__).parent / "baseline.json"
PAIRS = 15
RUNS = 3  # in which a ratio must be worse
LEAST_MARGIN = 0.2  # of the median: processors of one name are not all alike
BETWEEN_PROCESSORS = 1.15  # kernel over C on idle machines, 2026-11-24: 0.80 (AMD EPYC, 90f3d58), 0.92 (Intel Xeon, c658aac)
JUDGED = ("kernel over C", "recorder over mcap, plain")
PERIOD_S = 1e-3
SIMULATED_S, STEPS, TERMS, ROWS = 4.0, 400, 200_000, 3000
Work = Callable[[], object]
Baseline = Mapping[str, Mapping[str, float]]  # median and spread of each ratio


def kernel_and_c() -> tuple[Work, Work]:
    """The simulated testbed, 4 s of it. Raises FileNotFoundError without a C compiler."""
    sim = SimulatedRig(load_rig("ornl_testbed").rig)
    t = np.arange(round(SIMULATED_S / PERIOD_S)) * PERIOD_S
    commands = np.column_stack([0.5 * np.sin(2 * np.pi * t), 2 * np.sin(2 * np.pi * 0.7 * t)])
    plant, step_s = CPlant(sim, PERIOD_S), float(sim.parameters.values[C.STEP])

    def kernel() -> None:
        sim.reset()
        sim.run(commands, PERIOD_S)

    def in_c() -> None:
        sim.reset()
        plant.run(commands, step_s)

    return kernel, in_c


def controller_and_arithmetic() -> tuple[Work, Work]:
    """The paper's line with the adaptive filter, from its start; beside it sums of products."""
    rig = load_rig("ornl_testbed").rig
    maneuver = maneuver_content(load_maneuver(find("maneuvers", "paper_line")).maneuver)
    plan = plan_run(rig, RunRequest(1, maneuver, {"kind": "adaptive", "joints": ["rotary", "prismatic"]}))

    def steps() -> None:
        controller, position = Controller(rig), plan.start_position
        controller.prepare(plan)
        for cycle in range(STEPS):
            out = controller.step(Inputs(cycle, Mode.HOLDING if cycle < 10 else Mode.RUNNING, 1, position, nan, nan))
            position = tuple([joint.reference for joint in out.joints])

    def arithmetic() -> float:
        total = 0.0
        for number in range(TERMS):
            total += 0.5 * number
        return total

    return steps, arithmetic


def recorder_and_plain(folder: Path) -> tuple[Work, Work]:
    """Rows of the testbed's log, smooth numbers in every field."""
    layout = CycleLayout.of_rig(load_rig("ornl_testbed").rig)
    phases = np.linspace(0.0, 3.0, len(layout.blank()))
    blank = layout.blank()
    integer = np.array([isinstance(value, int) for value in blank])
    rows = []
    for row in range(ROWS):
        values = np.where(integer, row % 200, np.sin(1e-3 * row + phases))
        rows.append((row * 1_000_000, layout.pack([int(v) if whole else float(v) for v, whole in zip(values, integer, strict=True)])))

    def writing(make: Callable[[Path, CycleLayout], tuple[recorder.Write, recorder.Close]]) -> Work:
        def work() -> None:
            path = folder / "rows.mcap"
            path.unlink(missing_ok=True)
            write, close = make(path, layout)
            for t_ns, data in rows:
                write(t_ns, data)
            close()

        return work

    return writing(recorder.ours), writing(recorder.plain)


@contextmanager
def all_ways() -> Iterator[dict[str, tuple[Work, Work]]]:
    with tempfile.TemporaryDirectory() as folder:
        ways = {"recorder over mcap, plain": recorder_and_plain(Path(folder)), "controller over arithmetic": controller_and_arithmetic()}
        try:
            ways["kernel over C"] = kernel_and_c()
        except FileNotFoundError as missing:
            print(missing)
        for first, second in ways.values():  # nothing is measured cold
            first(), second()
        yield ways


def pairs_of(ways: Mapping[str, tuple[Work, Work]], pairs: int) -> dict[str, list[float]]:
    """Processor time of the first over that of the second, the ways and their sides by turns."""
    found: dict[str, list[float]] = {name: [] for name in ways}
    gc.collect()
    gc.disable()
    for turn in range(pairs):
        for name, sides in ways.items():
            spent = [0.0, 0.0]
            for side in (0, 1) if turn % 2 else (1, 0):
                began = time.process_time()
                sides[side]()
                spent[side] = time.process_time() - began
            found[name].append(spent[0] / spent[1])
    gc.enable()
    return found


def spread_of(runs: Sequence[Sequence[float]]) -> tuple[float, float]:
    """Median of the runs' medians, and their range."""
    medians = [median(run) for run in runs]
    return median(medians), max(medians) - min(medians)


def run_of_its_own() -> dict[str, list[float]]:
    """The pairs of one run, in a process of its own."""
    done = subprocess.run([sys.executable, "-m", "benchmarks.ratios", "--pairs"], stdout=subprocess.PIPE, check=True, text=True)
    found: dict[str, list[float]] = json.loads(done.stdout.splitlines()[-1])
    return found


def write_baseline(runs: int) -> None:
    seen = []
    for number in range(runs):
        seen.append(run_of_its_own())
        print(f"run {number + 1} of {runs}: " + ", ".join(f"{name} {median(found):.3f}" for name, found in seen[-1].items()), flush=True)
    ratios = {name: spread_of([run[name] for run in seen]) for name in seen[0]}
    facts, of_all = host(), kept_baselines()
    head = {"written": f"{datetime.now(UTC):%Y-%m-%d}", "commit": software()["software_commit"], "runs": runs, "pairs": PAIRS}
    figures = {name: {"median": middle, "spread": spread} for name, (middle, spread) in ratios.items()}
    content = {**of_all, facts["host_cpu"]: {**head, "host_python": facts["host_python"], "ratios": figures}}
    write_whole(BASELINE, json.dumps(content, indent=1) + "\n", "baseline")
    print(f"the baseline: {BASELINE}")


def kept_baselines() -> dict[str, Any]:  # by processor
    return dict(json.loads(BASELINE.read_text())) if BASELINE.exists() else {}


def limit_of(kept: Mapping[str, float]) -> float:
    return kept["median"] + max(0.5 * kept["spread"], LEAST_MARGIN * kept["median"])


def baseline_for(kept: Mapping[str, Any], cpu: str, python: str) -> tuple[Baseline, float]:
    """This processor's ratios, or of each ratio the loosest of the others; and what its limit is to be multiplied by."""
    same = {name: each["ratios"] for name, each in kept.items() if each["host_python"].split(".")[:2] == python.split(".")[:2]}
    if cpu in same:
        return same[cpu], 1.0
    each = sorted((item for ratios in same.values() for item in ratios.items()), key=lambda item: limit_of(item[1]))
    return dict(each), BETWEEN_PROCESSORS  # the loosest comes last, and stays


def judged(found: Mapping[str, Sequence[float]], baseline: Baseline, allowance: float = 1.0) -> Iterator[tuple[str, str, bool]]:
    """Name of each ratio, a line for it, and whether it has become worse."""
    for name, pairs in found.items():
        kept, now = baseline.get(name), median(pairs)
        shown = f"{name:28}{now:8.3f}  ({min(pairs):.3f} to {max(pairs):.3f} of {len(pairs)} pairs)"
        if kept is None:
            yield name, f"{shown}; no baseline", False
            continue
        limit = allowance * limit_of(kept)
        above = now > limit
        word = "ok" if not above else "WORSE" if name in JUDGED else "above, not judged"
        yield name, f"{shown}; baseline {kept['median']:.3f}, limit {limit:.3f}: {word}", above and name in JUDGED


def worse(run: Callable[[], Mapping[str, Sequence[float]]], baseline: Baseline, allowance: float = 1.0) -> list[str]:
    """Names of the ratios that are worse in a run and in all that are then made again; prints their tables."""
    names = set(JUDGED)
    for number in range(RUNS):
        lines = list(judged(run(), baseline, allowance))
        print(f"{'measured again: ' if number else ''}processor time over that of the other side, median of pairs; less is better")
        print("\n".join(line for _, line, _ in lines), flush=True)
        names &= {name for name, _, above in lines if above}
        if not names:
            break
    return sorted(names)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--write", action="store_true", help=f"make {BASELINE.name} anew")
    parser.add_argument("--runs", type=int, default=12, metavar="N", help="for the baseline (default %(default)s)")
    parser.add_argument("--pairs", action="store_true", help="one run, its pairs as JSON")
    arguments = parser.parse_args()
    if arguments.pairs:
        with all_ways() as ways:
            print(json.dumps(pairs_of(ways, PAIRS)))
        return 0
    if arguments.write:
        write_baseline(arguments.runs)
        return 0
    cpu, kept = host()["host_cpu"], kept_baselines()
    baseline, allowance = baseline_for(kept, cpu, host()["host_python"])
    print(f"baseline of {cpu}" if allowance == 1.0 else f"no baseline of {cpu}; limits of {', '.join(kept) or 'none'} times {allowance:g}")
    named = worse(run_of_its_own, baseline, allowance)
    if named:
        print(f"worse than {BASELINE.name} allows: {', '.join(named)}. If the change is worth it: python -m benchmarks.ratios --write")
    return 1 if named else 0


if __name__ == "__main__":
    sys.exit(main())
