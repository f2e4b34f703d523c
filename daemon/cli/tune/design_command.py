"""`design`: find the compensator of an arm's rotary joint, or of a single hydraulic axis, and write it into the rig file."""

from __future__ import annotations

import argparse
import dataclasses
import json
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from daemon.cli.connection import add_json_option
from daemon.cli.options.numbers import COUNT, finite
from daemon.cli.options.output_file import PICTURE, RIG_FILE, output_file

if TYPE_CHECKING:
    from config.loading.load import LoadedRig
    from config.schema.rig import Rig
    from tuning.loop_design.arm_design import ArmDesign
    from tuning.loop_design.measured_plant import MeasuredPlant


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("rig", nargs="?", default="ornl_testbed", metavar="RIG", help="a rig file or the name of a shipped one")
    parser.add_argument(
        "--tip-gain", type=finite(), help="gain of the end-point feedback it will run with (default: the rig file's, 0 without)"
    )
    parser.add_argument(
        "--largest-cycle", type=finite(0), default=inf, metavar="SHARE", help="allowed hunting, as share of the friction's deflection"
    )
    parser.add_argument("--effort", type=COUNT, default=25, help="generations of the search")
    parser.add_argument(
        "--log", type=Path, action="append", default=[], metavar="LOG",
        help="of sweeps or multisines of a single axis: its measured responses must keep the margins too; may be repeated",
    )  # fmt: skip
    parser.add_argument("--schedule", action="store_true", help="let the gain rise where the arm is shorter, as far as the demands allow")
    parser.add_argument("--picture", type=PICTURE, metavar="PICTURE.png", help="sensitivities and stiffness over the whole family")
    parser.add_argument(
        "--export",
        type=output_file(".mat"),
        metavar="DESIGN.mat",
        help="write linearised plants and compensator for MATLAB and python-control",
    )
    parser.add_argument("-o", "--output", type=RIG_FILE, metavar="RIG.yaml", help="write the rig file with the compensator found")
    add_json_option(parser)
    parser.set_defaults(run_command=_design)


def _design(arguments: argparse.Namespace) -> int:
    from config.loading.load import load_rig
    from config.whole_file import refuse_existing
    from tuning.loop_design.arm_design import as_overrides, design, designed_name
    from tuning.loop_design.design_export import check_export_path
    from tuning.loop_design.gain_schedule import gain_schedule
    from tuning.loop_design.stuck_arm import largest_friction_gain

    loaded = load_rig(arguments.rig)
    if loaded.rig.arm.kind == "single_axis":
        _refuse_what_an_arm_has(arguments)
    if arguments.export:
        check_export_path(arguments.export)
    if arguments.output:
        refuse_existing(arguments.output, "rig file", "Give the designed one a name of its own.")
    own = loaded.rig.end_point.gain if loaded.rig.end_point is not None else 0.0
    tip_gain = own if arguments.tip_gain is None else arguments.tip_gain
    measured = _measured(loaded.rig, arguments.log) if arguments.log else []
    found = design(loaded.rig, tip_gain, effort=arguments.effort, largest_cycle=arguments.largest_cycle, measured=measured)
    schedule = gain_schedule(loaded.rig, found.problem, found.chosen.servo) if arguments.schedule else []
    overrides = as_overrides(loaded.rig, found.chosen.servo, schedule)
    known = tip_gain > 0.0 and loaded.rig.servo[designed_name(loaded.rig)].oil_compensation is not None
    friction_gain = largest_friction_gain(loaded.rig, found.chosen.servo) if known else None
    _write_files(arguments, loaded, found, overrides)
    if arguments.json:
        print(json.dumps({**_answer(found), "schedule": schedule, "overrides": overrides, "largest_friction_gain": friction_gain}))
    else:
        report = [*_lines(loaded.rig, found), *_schedule_lines(schedule), *_friction_lines(friction_gain), ""]
        print("\n".join([*report, *(f"  --set {line!r}" for line in overrides)]))
        if written := [str(path) for path in (arguments.output, arguments.picture, arguments.export) if path]:
            print(f"written: {', '.join(written)}")
    return 0


def _measured(rig: Rig, logs: list[Path]) -> list[MeasuredPlant]:
    """UsageError for an arm: what is measured of it has the link in it, which its family is without."""
    from config.errors import UsageError
    from tuning.identification.identification import identify
    from tuning.loop_design.measured_plant import measured_plants

    if rig.arm.kind != "single_axis":
        what, advice = "an arm's family has responses of its own", "Leave --log out."
        raise UsageError(what, where="--log", limit="a single axis", next_step=advice, mend={"--log": None})
    return measured_plants(rig, [response.measured for response in identify(logs).responses])


def _write_files(arguments: argparse.Namespace, loaded: LoadedRig, found: ArmDesign, overrides: list[str]) -> None:
    """What was asked for of rig file, picture and export."""
    from config.loading.load import rig_from_text
    from config.loading.overrides import apply_overrides
    from config.whole_file import write_whole
    from tuning.loop_design.design_export import design_systems, write_design
    from tuning.loop_design.design_picture import design_picture

    if arguments.output:
        text = apply_overrides(loaded.text, overrides)
        rig_from_text(text, str(arguments.output))
        write_whole(arguments.output, text)
    if arguments.picture:
        design_picture(found, arguments.picture)
    if arguments.export:
        write_design(design_systems(loaded.rig, found), arguments.export)


def _refuse_what_an_arm_has(arguments: argparse.Namespace) -> None:
    """UsageError for an option that needs a link."""
    from config.errors import UsageError

    given = {"--tip-gain": arguments.tip_gain, "--schedule": arguments.schedule}
    named = ", ".join(option for option, value in given.items() if value)
    if named:
        advice, mend = f"Leave out {named}.", dict.fromkeys(given)
        raise UsageError("a single axis has no link", value=named, limit="a rotary_prismatic arm", next_step=advice, mend=mend)


def _lines(rig: Rig, found: Any) -> list[str]:
    from tuning.loop_design.arm_design import shown_gain

    lines = [f"{rig.name}: {'pure gain' if found.pure_gain_wins else 'lag-lead'} is the stiffer one under the same demands"]
    for name, one in (("lag-lead", found.lag_lead), ("pure gain", found.pure_gain)):
        sections = ", ".join(f"zero {zero:.2f} pole {pole:.2f} rad/s" for zero, pole in one.servo.sections) or "no sections"
        worst = one.worst
        lines.append(f"  {name:10} C(0) {shown_gain(rig, one.servo.gain)}, {sections}")
        lines.append(
            f"             worst member: gain margin {worst.gain_margin_dB:.1f} dB, phase margin {worst.phase_margin_deg:.1f} deg,"
            f" M_s {worst.sensitivity_peak:.2f}; least damping {one.least_damping:.4f}; |1+L| {one.stiffness_gain_dB:.1f} dB over the band"
        )
    for ratio, cycle in zip((1.0, 1.1, 1.2), found.hunting, strict=True):
        text = "none" if cycle is None else f"{cycle.frequency_Hz:.2f} Hz, {cycle.load_amplitude:.3f} of the friction's deflection"
        lines.append(f"  hunting with H_s/H_c = {ratio}: {text}")
    return lines


def _schedule_lines(schedule: list[tuple[float, float]]) -> list[str]:
    return ["  gain by extension: " + ", ".join(f"{extension:.3f} m x {factor:.2f}" for extension, factor in schedule)] if schedule else []


def _friction_lines(gain: float | None) -> list[str]:
    """None: no end-point feedback, or no friction known."""
    if gain is None:
        return []
    return [f"  end_point.friction_gain: at most {gain:.0f} s/rad, or a link whose payload is not known hums"]


def _answer(found: Any) -> dict[str, Any]:
    designs = {name: dataclasses.asdict(getattr(found, name)) for name in ("lag_lead", "pure_gain", "chosen")}
    hunting = [dataclasses.asdict(cycle) if cycle is not None else None for cycle in found.hunting]
    return {**designs, "hunting": hunting, "pure_gain_wins": found.pure_gain_wins}
