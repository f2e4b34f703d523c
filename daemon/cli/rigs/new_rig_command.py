"""`new-rig`: a rig file from data sheets, checked and tried on its own simulated plant before it is handed over."""

from __future__ import annotations

import argparse
import datetime
import json
import re
import sys
import tempfile
import unicodedata
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import ConfigError, UsageError
from config.whole_file import free_name, told_of
from daemon.cli.connection import add_json_option
from daemon.cli.rigs.questions import ARM, CYLINDER, QUESTIONS, ROTARY, answers, choose_kind
from daemon.cli.rigs.stated_axis import axis_of, stated

if TYPE_CHECKING:
    from tuning.new_rig.axis import Axis


Pair = tuple[float, float]


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", help="short name of the rig: small letters, digits, _ and -")
    parser.add_argument(
        "--kind", choices=(CYLINDER, ROTARY, ARM), help="a hydraulic cylinder, a rotary actuator, or both with a flexible link"
    )
    for question in QUESTIONS:
        default = f" (default {question.default})" if question.default else ""
        parser.add_argument(f"--{question.flag}", metavar="VALUE", help=question.text + default)
    parser.add_argument("--chamber-pressures", action="store_true", help="pressure sensors in both chambers")
    parser.add_argument("--description", default="", help="one line for logs and reports")
    parser.add_argument("-o", "--output", type=Path, metavar="DIR", help="where the files go (default ./NAME)")
    add_json_option(parser)
    parser.set_defaults(run_command=_new_rig)


def _new_rig(arguments: argparse.Namespace) -> int:
    from config.checking.check import check_rig
    from config.loading.load import load_rig, rig_from_text

    _refuse_name(arguments.name)
    folder: Path = arguments.output or Path(arguments.name)
    if folder.exists() and any(folder.iterdir()):
        advice, mend = "Choose another one with -o DIR.", {"-o": str(free_name(folder))}
        raise UsageError("the folder is not empty", value=str(folder), where="-o", next_step=advice, mend=mend)
    ask = input if sys.stdin.isatty() and not arguments.json else None
    files, axes = _made(arguments, ask)
    try:
        rig_from_text(files[arguments.name], f"{arguments.name}.yaml")  # before anything is written
    except ConfigError as error:
        advice = f"Change the option that this comes from, or an answer. {error.refusal.next_step}"
        raise UsageError(f"this would make no rig: {error.refusal.what}", value=error.refusal.value, next_step=advice) from error
    _write(folder, files)
    rig = folder / f"{arguments.name}.yaml"
    findings = [finding for finding in check_rig(load_rig(rig), datetime.date.today()) if finding.level != "ok"]
    _report(arguments, axes, folder, files, [f"{finding.level}: {finding.text}" for finding in findings])
    return 0


def _refuse_name(name: str) -> None:
    """Before anything is asked: the name stands in the files and in every log."""
    from config.schema.rig import RIG_NAME

    if re.match(RIG_NAME, name):
        return
    plain = unicodedata.normalize("NFKD", name.lower()).encode("ascii", "ignore").decode()
    better = re.sub(r"[^a-z0-9_-]+", "_", plain).strip("_-").lstrip("0123456789_-") or "my_rig"
    limit = "small letters, digits, _ and -, a letter first, 64 at most"
    raise UsageError("a rig cannot have this name", value=name, limit=limit, where="NAME", mend={name: better[:64]})


def _write(folder: Path, files: dict[str, str]) -> None:
    """All files or none: they are made beside the folder and put in its place."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    with told_of(folder), tempfile.TemporaryDirectory(prefix=f".{folder.name}-", dir=folder.parent) as temporary:
        made = Path(temporary) / folder.name
        made.mkdir()
        for stem, content in files.items():
            (made / f"{stem}.yaml").write_text(content, encoding="utf-8")
        made.replace(folder)


def _made(arguments: argparse.Namespace, ask: Any) -> tuple[dict[str, str], dict[str, Axis]]:
    """File stem → text, and the axes by their joints."""
    kind = choose_kind(arguments.kind, ask)
    given, assumed = answers(arguments, kind, ask)
    if kind == ARM:
        from daemon.cli.rigs.new_arm import arm_files

        return arm_files(arguments, given, assumed)
    from tuning.new_rig.maneuver_texts import maneuver_texts
    from tuning.new_rig.rig_text import rig_text

    axis, size = axis_of(given, kind == ROTARY)
    said = stated(arguments, given, assumed, size, "Rotary actuator" if axis.rotary else "Cylinder")
    return {arguments.name: rig_text(axis, said)} | maneuver_texts(axis, arguments.name, said.joint), {said.joint: axis}


def _facts(axis: Axis) -> dict[str, Any]:
    return {
        "full_speed": list(axis.speeds),
        "largest_force": axis.force,
        "hydraulic_frequency_Hz": axis.natural_frequency_rad_s / (2.0 * pi),
        "loop_gain_1_s": axis.loop_gain_1_s,
    }


def _report(arguments: argparse.Namespace, axes: dict[str, Axis], folder: Path, files: dict[str, str], findings: list[str]) -> None:
    written = [str(folder / f"{stem}.yaml") for stem in files]
    if arguments.json:
        facts = {joint: _facts(axis) for joint, axis in axes.items()}
        print(json.dumps({"written": written, "findings": findings, **(facts if len(axes) > 1 else next(iter(facts.values())))}))
        return
    print("\n".join([*(_line(joint, axis) for joint, axis in axes.items()), *findings, "written:", *(f"  {name}" for name in written)]))
    steps = folder / f"{arguments.name}_joint_steps.yaml"
    print(f"next:\n  longreach check {written[0]}\n  longreach simulate {written[0]} {steps} --plot")


def _line(joint: str, axis: Axis) -> str:
    from tuning.new_rig.rig_text import length

    out, back = axis.speeds
    speeds = f"{length(axis, out, '/s')} out, {length(axis, back, '/s')} back"
    rings = f"oil and mass ring at {axis.natural_frequency_rad_s / (2.0 * pi):.3g} Hz"
    return (
        f"{joint}: full speed {speeds}; force {axis.force:.3g} {'N m' if axis.rotary else 'N'}; {rings}; loop {axis.loop_gain_1_s:.3g} 1/s"
    )
