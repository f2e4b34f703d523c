"""How far a joint is from its reference, and from the ends of its travel."""

from __future__ import annotations

from math import inf

from config.schema.rig import Rig
from daemon.checks.checks import Reaction
from daemon.checks.declaration import Declaration, Family, Limits, Stage, Subject, joint_subject


def _travel(rig: Rig, subject: Subject) -> Limits:
    """With the following error as margin, so that a joint held at its end does not trip."""
    joint = rig.joints[subject["joint"]]
    return joint.travel[0] - joint.following_error_limit, joint.travel[1] + joint.following_error_limit


FOLLOWING_ERROR = Declaration(
    name="{joint} following error",
    fact="{joint}.following_error",
    meaning="distance of the measured position from its reference",
    unit="{unit}",
    limits=lambda rig, subject: (-inf, rig.joints[subject["joint"]].following_error_limit),
    limit_from="at most `joints.NAME.following_error_limit`",
    source="joint {joint}",
    reaction=Reaction.FAULT,
    advice="Check pressure, valve and polarity; compare command and position in the log: `longreach log plot`.",
)
TRAVEL = Declaration(
    name="{joint} travel",
    fact="{joint}.position",
    meaning="the measured position",
    unit="{unit}",
    limits=_travel,
    limit_from="`joints.NAME.travel`, widened at both ends by `joints.NAME.following_error_limit`",
    source="joint {joint}",
    reaction=Reaction.STOP,
    advice="Bring the joint back by hand, with the pressure off; then `longreach why`.",
)

FAMILIES = (Family("Motion", Stage.MOTION, lambda rig: [joint_subject(rig, joint) for joint in rig.joints], (FOLLOWING_ERROR, TRAVEL)),)
