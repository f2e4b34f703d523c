"""What planning needs to know of the joints, read once from the rig file, and the words its messages use."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees

from config.errors import ManeuverError
from config.parsing.nearest import nearest
from config.schema.rig import AnyJoint, Rig

# Share of a joint's limits used where speed does not matter: approach, return, jog.
SLOW_SHARE = 0.2


@dataclass(frozen=True, slots=True)
class JointLimits:
    """One joint of the rig: rad or m, per s, per s²."""

    name: str
    unit: str
    travel: tuple[float, float]
    rate: float
    acceleration: float
    command_V: float

    @property
    def start_tolerance(self) -> float:
        """How far the arm may be from a program's start: 0.2° or 2 mm."""
        return 0.0035 if self.unit == "rad" else 0.002

    def show(self, value: float) -> str:
        """A position with enough digits, and degrees beside radians."""
        return f"{value:.4f} rad ({degrees(value):.2f}°)" if self.unit == "rad" else f"{value:.4f} m"


def joint_limits(rig: Rig) -> tuple[JointLimits, ...]:
    """The joints in the order of the rig file."""
    return tuple(_limits(name, joint) for name, joint in rig.joints.items())


def _limits(name: str, joint: AnyJoint) -> JointLimits:
    unit = joint.position_unit
    return JointLimits(name, unit, joint.travel, joint.rate_limit, joint.acceleration_limit, joint.command_limit_V)


def joint_index(joints: tuple[JointLimits, ...], name: str, where: str, key: str = "") -> int:
    """Raises ManeuverError for a joint the rig has not. `key`: what a maneuver file says it with, where it can be said anew."""
    names = [joint.name for joint in joints]
    if name not in names:
        meant = nearest(name, names) or (names[0] if len(names) == 1 else None)
        advice = (
            "Name a joint of the rig, with ways and speeds in its unit."
            if meant is None
            else f"Name {meant}, with ways and speeds in its unit."
        )
        mend = {key: meant} if key and meant else {}
        raise ManeuverError("the rig has no such joint", value=name, limit=", ".join(names), where=where, next_step=advice, mend=mend)
    return names.index(name)


def in_joint_units(value: float | str, joint: JointLimits, per: str = "", where: str = "") -> float:
    """A joint quantity of a maneuver file as a number; a unit written with it must be the joint's. `per`: '', '/s' or '/s^2'."""
    if not isinstance(value, str):
        return float(value)
    number, _, unit = value.partition(" ")
    if unit != joint.unit + per:
        what, advice = f"wrong kind of unit for the joint {joint.name}", f"Write it in {joint.unit + per}, or in a unit of the same kind."
        raise ManeuverError(what, value=f"{float(number):.6g} {unit}", limit=joint.unit + per, where=where, next_step=advice)
    return float(number)


def in_volts(value: float | str, per: str = "", where: str = "") -> float:
    """An amplitude on the command as a number of volts."""
    if not isinstance(value, str):
        return float(value)
    number, _, unit = value.partition(" ")
    if unit != "V" + per:
        what = "an excitation on the command is in volts"
        raise ManeuverError(what, value=f"{float(number):.6g} {unit}", limit="V" + per, where=where, next_step=f"Write it in V{per}.")
    return float(number)
