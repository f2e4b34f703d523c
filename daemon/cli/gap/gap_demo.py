"""`gap demo`: a seed chooses an effect of the true rig that the model's rig file lacks; the finder sees logs and that file, no more."""

from __future__ import annotations

import argparse
import json
import random
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.progress import Progress
from daemon.cli.connection import add_json_option
from daemon.cli.options.numbers import SEED
from daemon.cli.shown.progress import progress_lines

if TYPE_CHECKING:
    from config.loading.load import LoadedRig

MANEUVERS = {"fit": "paper_line", "holdout": "joint_steps", "unused": "paper_line_y30"}
# Effects that these maneuvers show at the size they have here; stiction and viscous friction of the prismatic joint are below it.
HIDDEN = (
    ("coulomb_friction", "rotary"), ("viscous_friction", "rotary"), ("cross_leakage", "rotary"), ("link_flexibility", "link"),
    ("coulomb_friction", "prismatic"), ("cross_leakage", "prismatic"), ("valve_lag", "rotary"), ("hose_compliance", "rotary"),
)  # fmt: skip


def register(verbs: Any) -> None:
    parser = verbs.add_parser("demo", help="hide an effect of the simulated rig, log three maneuvers, find it, show the gap shrink")
    parser.add_argument("--seed", type=SEED, default=1, help="chooses the hidden effect (default 1)")
    parser.add_argument("--out", type=Path, default=Path("gap-demo"), metavar="DIR", help="logs, findings and picture (default ./gap-demo)")
    add_json_option(parser)
    parser.set_defaults(run_command=_demo)


def _demo(arguments: argparse.Namespace) -> int:
    return run_demo(arguments.seed, arguments.out, progress_lines(arguments.json), arguments.json)


def run_demo(seed: int, out: Path, progress: Progress, as_json: bool) -> int:
    """Hide, log, find, compare. Exit 0 when the hidden effect is named or in the set, 1 when not."""
    from config.loading.load import load_rig
    from gap.find import find
    from gap.report.picture import write_picture

    out.mkdir(parents=True, exist_ok=True)
    whole = load_rig("ornl_testbed")
    effect, where = random.Random(seed).choice(HIDDEN)
    model = out / "model.yaml"
    model.write_text(without(whole.text, effect, where))
    logs = logged(whole, out, seed, progress)
    found = find(model, [logs["fit"]], [logs["holdout"]], out, progress, unused=[logs["unused"]])
    named = [(f["effect"], f["where"]) for f in found.content["findings"]]
    named += [(x["effect"], x["where"]) for f in found.content["findings"] for x in f["look_alikes"]]
    right = (effect, where) in named
    said = ", ".join(f"{e} at {w}" for e, w in named) or "nothing"
    write_picture(found, out / "gap-demo.png", f"hidden: {effect} at {where}; found: {said} ({found.verdict.word})")
    if as_json:
        print(json.dumps({"hidden": {"effect": effect, "where": where}, "right": right, "findings": found.content}))
    else:
        print(f"hidden: {effect} at {where}\nfound: {said} ({found.verdict.word})")
        print("\n".join(shrinking(found.content)))
        print(f"picture: {out / 'gap-demo.png'}; report: {out / 'report.html'}; improved rig file: {out / 'rig.yaml'}")
    return 0 if right else 1


def shrinking(content: dict[str, Any]) -> list[str]:
    """The gap before and after on the log that decided and on the one that was never used."""
    gap = content["gap"]
    lines = [f"hold-out gap: {gap['holdout_before']:.4g} → {gap['holdout_after']:.4g} noise floors"]
    return lines + [f"gap on a log never used: {x['before']:.4g} → {x['after']:.4g} noise floors" for x in content["unused_logs"]]


def without(text: str, effect: str, where: str) -> str:
    """The rig file without one entry of plant.effects."""
    entry = re.compile(rf"^\s*- \{{effect: {effect}, where: {where},.*\n", re.MULTILINE)
    return entry.sub("", text, count=1)


def logged(whole: LoadedRig, out: Path, seed: int, progress: Progress) -> dict[str, Path]:
    """One log a maneuver, through the daemon's loop and recorder on the virtual clock."""
    from config.loading.load import LoadedRig, rig_from_text
    from daemon.lockstep import run_lockstep

    logs = {}
    for k, (use, maneuver) in enumerate(MANEUVERS.items()):
        progress(f"running {maneuver} on the whole rig")
        request = {"maneuver": {"name": maneuver}, "approach": True}
        logs[use] = run_lockstep(LoadedRig(rig_from_text(whole.text), whole.text, whole.path), [request], out / use, seed=seed + k)[0]
    return logs
