"""Look-alikes: hidden effects whose first logs cannot tell them from another, and whether the proposed maneuvers do.

    python -m benchmarks.gap.look_alikes [force_axis | two_encoders | one_way | ornl_testbed] [--out FOLDER] [--cases 0 3 7] [--seed 100]

One line a case: what the first search said, how many rounds it took, how it ended. Every case leaves row.json in its folder; a case that
has one is not run again. Summary at the end.
"""

from __future__ import annotations

import argparse
import json
import re
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.gap.look_alike_cases import BENCHES, Case, LookAlikeBench
from config.loading.load import LoadedRig, load_rig, rig_from_text
from daemon.cli.gap.gap_loop import runner
from gap.loop import LoopCourse, Run, resolve


def rigs_of(bench: LookAlikeBench, case: Case) -> tuple[str, LoadedRig, tuple[str, str]]:
    """Text of the model, the true rig, and the hidden effect."""
    shipped = load_rig(bench.rig)
    text = shipped.text
    for old, new in bench.edits:
        text = text.replace(old, new)
    if isinstance(case, tuple):
        entry = re.compile(rf"^\s*- \{{effect: {case[0]}, where: {case[1]},.*\n", re.MULTILINE)
        return entry.sub("", text, count=1), LoadedRig(rig_from_text(text), text, shipped.path), case
    truth = re.sub(r"^  effects:\n", f"  effects:\n    - {case}\n", text, count=1, flags=re.MULTILINE)
    return text, LoadedRig(rig_from_text(truth), truth, shipped.path), _effect_of(case)


def _effect_of(case: str) -> tuple[str, str]:
    found = re.match(r"\{effect: (\w+), where: '?([\w:.]+)'?,", case)
    assert found
    return found[1], found[2]


def hidden_and_logged(bench: LookAlikeBench, case: Case, seed: int, out: Path) -> tuple[str, list[Path], Run]:
    """What is hidden, the first two logs, and what runs further maneuvers; the search's rig file is written to `out`/model.yaml."""
    model, truth, hidden = rigs_of(bench, case)
    out.mkdir(parents=True, exist_ok=True)
    (out / "model.yaml").write_text(model)
    run = runner(truth, out, seed, lambda line: None)
    return " at ".join(hidden), [run(design, use) for design, use in zip(bench.first, ("fit", "holdout"), strict=True)], run


def run_case(bench: LookAlikeBench, case: Case, seed: int, out: Path) -> dict[str, Any]:
    """Logs, rounds of search and maneuver, and how it ended, as the content of row.json."""
    start = time.monotonic()
    hidden, logs, run = hidden_and_logged(bench, case, seed, out)
    course = resolve(out / "model.yaml", logs[:1], logs[1:], out, run, lambda line: None, lambda one: None)
    return _judged(course, hidden) | {"hidden": hidden, "seconds": round(time.monotonic() - start, 1)}


def _judged(course: LoopCourse, label: str) -> dict[str, Any]:
    begin, last = course.rounds[0], course.rounds[-1]
    confirmed = course.outcome == "confirmed" and not last.open_sets
    return {
        "first_verdict": begin.content["verdict"],
        "first_sets": begin.open_sets or [begin.names],
        "in_first": label in [*begin.names, *(name for names in begin.open_sets for name in names)],
        "unresolved_at_first": not begin.settled,
        "rounds": len(course.rounds),
        "asked": [one.asked.label for one in course.rounds[:-1] if one.asked],
        "outcome": course.outcome,
        "why": course.why,
        "names": last.names,
        "sets": last.open_sets,
        "resolved": confirmed and last.names == [label],
        "wrong": confirmed and bool(last.names) and label not in last.names,
    }


def summary(rows: Sequence[Mapping[str, Any]]) -> str:
    """Counts over the cases. What ends with a sensor asked for is no failure of the maneuvers, if the hidden effect is in the set."""
    doubtful = [row for row in rows if row["unresolved_at_first"]]
    asked = [row for row in doubtful if row["asked"]]
    sensor = [row for row in doubtful if row["outcome"] == "needs_sensor"]
    to_run = [row for row in asked if row["outcome"] != "needs_sensor"]
    counts = (
        f"in doubt after the first logs: {len(doubtful)} of {len(rows)}",
        f"a maneuver was proposed and run: {len(asked)}",
        f"resolved to the hidden effect alone: {sum(row['resolved'] for row in to_run)} of {len(to_run)} that maneuvers can resolve",
        f"only another sensor can, says the search: {len(sensor)}, the hidden effect in the set: "
        f"{sum(any(row['hidden'] in names for names in row['sets']) for row in sensor)}",
        f"another effect confirmed instead: {sum(row['wrong'] for row in rows)}",
    )
    return "\n".join(counts)


def _line(number: int, row: Mapping[str, Any]) -> str:
    end = "resolved" if row["resolved"] else f"NOT resolved ({row['why']})"
    course = f"{row['first_verdict']} {row['first_sets']} → {row['outcome']} {row['sets'] or row['names']}"
    return f"{number} {row['hidden']}: {course}, {row['rounds']} rounds, {end}, {row['seconds']} s"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gap.look_alikes")
    parser.add_argument("bench", nargs="?", default="force_axis", choices=tuple(BENCHES))
    parser.add_argument("--out", type=Path, default=Path("look-alikes"))
    parser.add_argument("--cases", type=int, nargs="*")
    parser.add_argument("--seed", type=int, default=100, help="of the first case's noise (default 100)")
    arguments = parser.parse_args()
    bench, rows = BENCHES[arguments.bench], []
    for number in range(len(bench.cases)) if arguments.cases is None else arguments.cases:
        folder = arguments.out / f"{arguments.bench}-{arguments.seed}-{number:02}"
        done = folder / "row.json"
        if not done.exists():
            row = run_case(bench, bench.cases[number], arguments.seed + 10 * number, folder)
            done.write_text(json.dumps(row, indent=2) + "\n")
        rows.append(json.loads(done.read_text()))
        print(_line(number, rows[-1]), flush=True)
    print(summary(rows))


if __name__ == "__main__":
    main()
