"""`gap loop`: search, run the maneuver that would tell on a simulated rig through the daemon, search again, until settled."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import ConfigError
from config.progress import Progress
from daemon.cli.connection import add_json_option
from daemon.cli.gap.gap_next import advice
from daemon.cli.options.numbers import COUNT, SEED
from daemon.cli.shown.progress import progress_lines

if TYPE_CHECKING:
    from config.loading.load import LoadedRig
    from config.schema.rig import Rig
    from gap.loop import LoopCourse, Round
    from gap.maneuvers.designs import ManeuverDesign


def register(verbs: Any) -> None:
    parser = verbs.add_parser("loop", help="search and run the maneuver that would tell, in turn, with a simulated rig as the measured one")
    parser.add_argument("--rig", required=True, metavar="RIG.yaml", help="the model: a rig file, or the name of a shipped rig")
    parser.add_argument("--truth-rig", required=True, metavar="TRUTH.yaml", help="the rig that is run; the search never sees it")
    parser.add_argument("--log", type=Path, action="append", default=[], metavar="LOG", help="logs to begin with (default: two are run)")
    parser.add_argument("--holdout", type=Path, action="append", default=[], metavar="LOG", help="logs held out to begin with")
    parser.add_argument("--out", type=Path, default=Path("gap-loop"), metavar="DIR", help="every log and every round's results")
    parser.add_argument("--rounds", type=COUNT, default=4, metavar="N", help="most searches (default 4)")
    parser.add_argument("--seed", type=SEED, default=1, help="of the simulated sensors' noise (default 1)")
    add_json_option(parser)
    parser.set_defaults(run_command=_loop)


def _loop(arguments: argparse.Namespace) -> int:
    from config.loading.load import load_rig
    from gap.loop import first_designs, resolve

    progress = progress_lines(arguments.json)
    truth = load_rig(arguments.truth_rig)
    run = runner(truth, arguments.out, arguments.seed, progress)
    if bool(arguments.log) != bool(arguments.holdout):
        advice, mend = "Give both or neither; then two are run.", {"--log": None, "--holdout": None}
        raise ConfigError("--log and --holdout go together", where="gap loop", next_step=advice, mend=mend)
    _refuse_other_joints(load_rig(arguments.rig).rig, truth.rig)
    logs, holdouts = arguments.log, arguments.holdout
    if not logs:
        first, second = first_designs(truth.rig)
        logs, holdouts = [run(first, "fit")], [run(second, "holdout")]
    show = (lambda one: None) if arguments.json else show_round
    course = resolve(arguments.rig, logs, holdouts, arguments.out, run, progress, show, arguments.rounds)
    print(json.dumps(course.as_dict()) if arguments.json else conclusion(course, arguments.out))
    return 0


def _refuse_other_joints(model: Rig, truth: Rig) -> None:
    """Before anything is run: no log of the one could be compared with the other."""
    if tuple(model.joints) != tuple(truth.joints):
        what, seen, wanted = "the rig that is run has other joints than the model", ", ".join(truth.joints), ", ".join(model.joints)
        advice = "Give a variant of the model's own file."
        raise ConfigError(what, value=seen, limit=wanted, where="--truth-rig", next_step=advice)


def runner(truth: LoadedRig, out: Path, seed: int, progress: Progress) -> Callable[[ManeuverDesign, str], Path]:
    """Runs a design on the true rig through the daemon's loop and recorder on the virtual clock; each run has noise of its own."""
    from daemon.lockstep import run_lockstep

    runs: list[Path] = []

    def run(design: ManeuverDesign, name: str) -> Path:
        progress(f"running {design.label} on {truth.rig.name}")
        runs.append(run_lockstep(truth, [design.request], out / "logs" / name, seed=seed + len(runs))[0])
        return runs[-1]

    return run


def show_round(one: Round) -> None:
    """One round as it ends."""
    from gap.outcome.findings import explanations

    gap = one.content["gap"]
    print(f"round {one.number}: {one.content['verdict']}; hold-out {gap['holdout_before']:.4g} → {gap['holdout_after']:.4g} noise floors")
    for item in explanations(one.content):
        alike = "".join(f" or {x['effect']} at {x['where']}" for x in item["look_alikes"])
        grade = "confirmed" if item["confirmed"] else "not confirmed"
        print(f"  {item['effect']} at {item['where']}{alike}: {grade}")
    if one.content["next_maneuver"] and not one.settled:
        print("  " + advice(one.content["next_maneuver"]).replace("\n", "\n  "), flush=True)


def conclusion(course: LoopCourse, out: Path) -> str:
    last = course.rounds[-1]
    return f"{course.outcome.replace('_', ' ')}: {course.why}\nlogs: {out / 'logs'}; report: {out / f'round-{last.number}' / 'report.html'}"
