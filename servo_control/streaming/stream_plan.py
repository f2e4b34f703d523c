"""A run that is driven by hand, checked and ready to start: the limits of its target, and the command filter behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, isfinite
from typing import Any

from config.errors import ManeuverError
from config.schema.rig import Rig
from servo_control.link.kinematics import joint_rates
from servo_control.path.joint_limits import JointLimits, joint_limits
from servo_control.path.program import Segment
from servo_control.planning.run_plan import Peaks
from servo_control.planning.run_request import BY_HAND, RunRequest
from servo_control.shapers.shaper_choice import WHERE, ShaperChoice
from servo_control.shapers.shaper_setup import Extensions, ShaperSetup, extension_index, set_up_shaper
from servo_control.streaming.filter_margin import input_limits

# The others can overshoot, or must know a move before it begins.
FILTERS = ("none", "zv", "zvd", "ei", "two_hump_ei", "adaptive", "adaptive_zv")


@dataclass(frozen=True, slots=True)
class StreamPlan:
    """What a RunPlan is to a program. `rates` and `accelerations` are those of the target; `rate_limits` what may be asked for.

    `timeout_s`: how late a set point may be, and how long one may stay away. `tip_speed_mps`: what may be asked of the tip, 0 where the
    arm has none.
    """

    request: RunRequest
    shaper: ShaperSetup
    joints: tuple[str, ...]
    start_position: tuple[float, ...]
    travel: tuple[tuple[float, float], ...]
    rates: tuple[float, ...]
    accelerations: tuple[float, ...]
    rate_limits: tuple[float, ...]
    flush_s: float
    timeout_s: float
    tip_speed_mps: float = 0.0
    hub_offset_m: float = 0.0

    @property
    def run(self) -> int:
        return self.request.run

    @property
    def duration_s(self) -> float:
        """Nobody knows."""
        return float("inf")

    @property
    def peaks(self) -> tuple[Peaks, ...]:
        limits = zip(self.travel, self.rates, self.accelerations, strict=True)
        return tuple(Peaks(low, high, rate, acceleration) for (low, high), rate, acceleration in limits)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """There is no program."""
        return ()

    def joint_rates(self, position: Sequence[float], velocity: Sequence[float]) -> tuple[float, float]:
        """Of (rotary, prismatic), for a velocity (x, y) of the tip in m/s."""
        return joint_rates((position[0], position[1]), (velocity[0], velocity[1]), self.hub_offset_m)

    def summary(self) -> dict[str, Any]:
        """JSON-able facts for whoever drives."""
        by_joint = zip(self.joints, self.travel, self.rates, self.accelerations, strict=True)
        return {
            "run": self.run,
            "maneuver": self.request.maneuver["name"],
            "kind": BY_HAND,
            "duration_s": None,
            "segments": [],
            "shaper": self.shaper.kind,
            "shaped_joints": [self.joints[j] for j in self.shaper.joints],
            "flush_s": self.flush_s,
            "limits": {name: {"travel": list(travel), "rate": rate, "acceleration": a} for name, travel, rate, a in by_joint},
            "tip_speed_mps": self.tip_speed_mps,
            "timeout_s": self.timeout_s,
        }


def plan_stream(rig: Rig, request: RunRequest) -> StreamPlan:
    """Raises ManeuverError for a filter that cannot be used by hand, and for a start without a position of every joint."""
    joints = joint_limits(rig)
    start = tuple(request.start_position)
    if len(start) != len(joints) or not all(map(isfinite, start)):
        raise ManeuverError("driving by hand begins where the arm is, so start_position needs every joint", value=list(start))
    setup = _shaper(rig, request, joints, start)
    rates, accelerations = input_limits(setup, joints)
    return StreamPlan(
        request=request,
        shaper=setup,
        joints=tuple(joint.name for joint in joints),
        start_position=start,
        travel=tuple(joint.travel for joint in joints),
        rates=tuple(rates),
        accelerations=tuple(accelerations),
        rate_limits=tuple(joint.rate for joint in joints),
        flush_s=setup.build().flush_s,
        timeout_s=rig.loop.set_point_timeout_s,
        tip_speed_mps=_tip_speed(rig, joints),
        hub_offset_m=rig.arm.hub_offset_m,
    )


def default_filter(rig: Rig) -> dict[str, Any]:
    """The shaper part of a request that names none: after the link's frequency on all joints, none where no link is known."""
    joints = joint_limits(rig)
    if rig.link_mode is None or extension_index(joints) is None:
        return {"kind": "none"}
    return {"kind": "adaptive", "joints": [joint.name for joint in joints]}


def _shaper(rig: Rig, request: RunRequest, joints: tuple[JointLimits, ...], start: Sequence[float]) -> ShaperSetup:
    choice = ShaperChoice.from_content(request.shaper)
    if choice.kind not in FILTERS:
        raise ManeuverError(
            "this filter cannot be used when driving by hand: it can overshoot, or must know a move before it begins",
            value=choice.kind,
            limit=", ".join(FILTERS),
            where=WHERE,
            next_step="Leave the filter to the rig: `longreach jog` without --shaper.",
        )
    j = extension_index(joints)
    extensions = None if j is None else Extensions(start[j], start[j], *joints[j].travel)
    return set_up_shaper(rig, choice, extensions)


def _tip_speed(rig: Rig, joints: tuple[JointLimits, ...]) -> float:
    """Both joints at their limits, far out."""
    if [joint.name for joint in joints] != ["rotary", "prismatic"]:
        return 0.0
    rotary, prismatic = joints
    return hypot(prismatic.rate, (rig.arm.hub_offset_m + prismatic.travel[1]) * rotary.rate)
