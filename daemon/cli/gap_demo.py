"""`gap demo`: an effect chosen by a seed is taken out of the model's rig file; the finder sees the logs of the whole rig and that file."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable
from pathlib import Path

from config.load import LoadedRig, load_rig, rig_from_text
from daemon.lockstep import run_lockstep
from gap.find import find

MANEUVERS = {"fit": "paper_line", "holdout": "joint_steps"}
HIDDEN = (
    ("coulomb_friction", "rotary"), ("viscous_friction", "rotary"), ("cross_leakage", "rotary"), ("link_flexibility", "link"),
    ("coulomb_friction", "prismatic"), ("viscous_friction", "prismatic"), ("valve_null_bias", "prismatic"),
)  # fmt: skip


def run_demo(seed: int, out: Path, tell: Callable[[str], None], as_json: bool) -> int:
    """Hide, log, find, compare. Exit 0 when the hidden effect is named or in the set, 1 when not."""
    out.mkdir(parents=True, exist_ok=True)
    whole = load_rig("ornl_testbed")
    effect, where = random.Random(seed).choice(HIDDEN)
    model = out / "model.yaml"
    model.write_text(without(whole.text, effect, where))
    logs = logged(whole, out, seed, tell)
    found = find(model, [logs["fit"]], [logs["holdout"]], out, tell)
    named = [(f["effect"], f["where"]) for f in found.content["findings"]]
    named += [(x["effect"], x["where"]) for f in found.content["findings"] for x in f["look_alikes"]]
    gap = found.content["gap"]
    right = (effect, where) in named
    if as_json:
        print(json.dumps({"hidden": {"effect": effect, "where": where}, "right": right, "findings": found.content}))
    else:
        print(f"hidden: {effect} at {where}; found: {', '.join(f'{e} at {w}' for e, w in named) or 'nothing'} ({found.verdict.word})")
        print(f"hold-out gap: {gap['holdout_before']:.4g} → {gap['holdout_after']:.4g} noise floors; report: {out / 'report.html'}")
    return 0 if right else 1


def without(text: str, effect: str, where: str) -> str:
    """The rig file without one entry of plant.effects."""
    entry = re.compile(rf"^\s*- \{{effect: {effect}, where: {where},.*\n", re.MULTILINE)
    return entry.sub("", text, count=1)


def logged(whole: LoadedRig, out: Path, seed: int, tell: Callable[[str], None]) -> dict[str, Path]:
    """One log a maneuver, through the daemon's loop and recorder on the virtual clock."""
    logs = {}
    for k, (use, maneuver) in enumerate(MANEUVERS.items()):
        tell(f"running {maneuver} on the whole rig")
        request = {"maneuver": {"name": maneuver}, "approach": True}
        logs[use] = run_lockstep(LoadedRig(rig_from_text(whole.text), whole.text, whole.path), [request], out / use, seed=seed + k)[0]
    return logs
