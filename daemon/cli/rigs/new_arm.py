"""From the answers to an arm with a flexible link: two axes, the tube between them, a servo gain and end-point feedback
that its own plant bears."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from config.errors import UsageError
from daemon.cli.rigs.questions import number
from daemon.cli.rigs.stated_axis import axis_of, stated

if TYPE_CHECKING:
    from tuning.new_rig.arm import Tube
    from tuning.new_rig.arm_text import Deflection
    from tuning.new_rig.axis import Axis

JOINTS = ("rotary", "prismatic")


def arm_files(arguments: argparse.Namespace, given: Mapping[str, str], assumed: frozenset[str]) -> tuple[dict[str, str], dict[str, Axis]]:
    """File stem → text, and the axes by their joints."""
    from config.loading.load import rig_from_text
    from tuning.new_rig.arm import with_stable_gain, with_tip_limits
    from tuning.new_rig.arm_maneuvers import arm_maneuver_texts
    from tuning.new_rig.arm_text import ArmStated, arm_text
    from tuning.new_rig.tip_feedback import tip_feedback

    tube, (shortest, longest) = _tube(given), _extension(given)
    words = {joint: _words(given, joint, tube, (shortest, longest)) for joint in JOINTS}
    (rotary, of_rotary), (prismatic, of_prismatic) = (axis_of(words[joint], joint == "rotary") for joint in JOINTS)
    rotary, prismatic = with_tip_limits(rotary, longest), replace(prismatic, low=shortest, high=longest)
    both = [
        stated(arguments, {**words[joint], "inertia": ""}, assumed, size, "Arm")
        for joint, size in zip(JOINTS, (of_rotary, of_prismatic), strict=True)
    ]
    material = f"{given['tube_outside']} / {given['tube_inside']} {tube.material} tube"
    link = {key: given[key] for key in ("hub_inertia", "carriage", "payload")}
    said = ArmStated(both[0], both[1], link | {"total_length": given["tube_length"], "tube": material}, _deflection(given))
    name = f"{arguments.name}.yaml"
    rotary = with_stable_gain(rotary, rig_from_text(arm_text(rotary, prismatic, tube, said), name))
    if said.deflection is not None:
        said = replace(said, feedback=tip_feedback(rig_from_text(arm_text(rotary, prismatic, tube, said), name)))
    files = {arguments.name: arm_text(rotary, prismatic, tube, said)} | arm_maneuver_texts(rotary, prismatic, arguments.name)
    return files, {"rotary": rotary, "prismatic": prismatic}


def _deflection(given: Mapping[str, str]) -> Deflection | None:
    """None where its range is 0."""
    from tuning.new_rig.arm_text import Deflection

    most_m = number(given["deflection_range"], "m")
    found = Deflection(most_m, given["deflection_range"], given["deflection_resolution"], given["deflection_noise"])
    return found if most_m > 0.0 else None


def _tube(given: Mapping[str, str]) -> Tube:
    from tuning.new_rig.arm import MATERIALS, Tube

    if given["tube_material"] not in MATERIALS:
        advice = f"Give one of {', '.join(MATERIALS)}; another: write its bending_stiffness and mass_per_length into the file."
        mend = {"--tube-material": next(iter(MATERIALS))}
        what = "this is no material of a tube"
        raise UsageError(what, value=given["tube_material"], where="--tube-material", next_step=advice, mend=mend)
    sizes = {"outside": "tube_outside", "inside": "tube_inside", "total_length": "tube_length"}
    masses = {"carriage": "carriage", "payload": "payload"}
    tube = Tube(
        material=given["tube_material"],
        hub_inertia=number(given["hub_inertia"], "kg*m^2"),
        **{key: number(given[word], "m") for key, word in sizes.items()},
        **{key: number(given[word], "kg") for key, word in masses.items()},
    )
    if not 0.0 <= tube.inside < tube.outside:
        raise UsageError("no wall is left", where="--tube-inside", next_step="The inside must be smaller than the outside.")
    return tube


def _extension(given: Mapping[str, str]) -> tuple[float, float]:
    shortest, longest, whole = (number(given[key], "m") for key in ("shortest", "longest", "tube_length"))
    if not 0.0 < shortest < longest <= whole:
        advice = "From the hub's axis to the payload: 0 < --shortest < --longest, and no longer than --tube-length."
        raise UsageError("this is no range of an extension", value=f"{shortest:g} to {longest:g} m", where="new-rig", next_step=advice)
    return shortest, longest


def _words(given: Mapping[str, str], joint: str, tube: Tube, extension: tuple[float, float]) -> dict[str, str]:
    """The answers of one axis, as for an axis alone; what it moves is the link with its payload, at its heaviest."""
    shared = {key: given[key] for key in ("dead_volume", "rated_drop", "full_scale", "stroke_time", "supply", "iso_vg")}
    own = {
        "joint": joint,
        "rated_flow": given[f"{joint}_flow"],
        "resolution": given[f"{joint}_resolution"],
        "noise": given[f"{joint}_noise"],
    }
    if joint == "rotary":
        moved = {"displacement": given["displacement"], "angle": given["angle"], "inertia": f"{tube.inertia(extension[1]):.6g} kg*m^2"}
    else:
        stroke = f"{extension[1] - extension[0]:.9g} m"
        moved = {"bore": given["bore"], "rod": given["rod"], "stroke": stroke, "mass": f"{tube.sliding_mass:.6g} kg"}
    return shared | own | moved
