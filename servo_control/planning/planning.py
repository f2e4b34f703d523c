"""plan_run: from a rig and a run request to a run that is safe to start, or a refusal that says what to change."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite, sqrt
from typing import Any

from pydantic import ValidationError

from config.errors import ManeuverError
from config.schema.maneuver import JointManeuver, Maneuver, StraightLine, maneuver_from_content
from config.schema.rig import Rig
from servo_control.link.kinematics import inverse
from servo_control.path.joint_limits import SLOW_SHARE, JointLimits, in_joint_units, joint_index, joint_limits
from servo_control.path.maneuver_pieces import PIECES, Ground
from servo_control.path.pieces import Dwell, JointMove, Piece, Vector
from servo_control.path.program import Program
from servo_control.path.repeats import repeated
from servo_control.path.smooth_moves import smooth_moves
from servo_control.planning.plan_checks import check_position, check_program, check_volts, program_peaks
from servo_control.planning.prediction import predict
from servo_control.planning.run_plan import Peaks, RunPlan, TipMotion
from servo_control.planning.run_request import RunRequest
from servo_control.planning.tip_motion import checked_tip, tip_peaks
from servo_control.shapers.shaper_choice import FASTER_MOVES, ShaperChoice
from servo_control.shapers.shaper_setup import Extensions, ShaperSetup, extension_index, set_up_shaper
from servo_control.shapers.zero_delay_moves import correct_moves

APPROACH = "--approach"  # the option that asks for one
APPROACH_HOLD_S = 2.0
LONGEST_SHAPED_S = 600.0
SLOWER_SHARES = (0.9, 0.8, 0.65, 0.5)  # of speed and acceleration, tried one after the other: a second or two each


def plan_run(rig: Rig, request: RunRequest) -> RunPlan:
    """Plan and check a run. Raises ManeuverError naming value, limit, unit, place and what to do next.

    The program starts at its own start; an arm elsewhere is refused, or taken there slowly first (`request.approach`).
    """
    if request.by_hand:
        raise ManeuverError("the run was driven by hand: it has no program to plan", value=request.run, next_step="See its set points.")
    try:
        return _plan(rig, request)
    except ManeuverError as error:
        share, slower = _slower(rig, request)
        if not slower:
            raise
        parts = error.refusal
        advice = f"It is possible at {share:g} of its pace: {', '.join(f'{key} {value}' for key, value in slower.items())}."
        raise ManeuverError(
            parts.what, value=parts.value, limit=parts.limit, unit=parts.unit, where=parts.where, next_step=advice, mend=slower
        ) from error


def _slower(rig: Rig, request: RunRequest) -> tuple[float, dict[str, str]]:
    """What a line that a filter makes too fast for the joints would need, as a share of its pace and by key; nothing where none helps.

    A correction does not shrink as the pace does, so it is tried.
    """
    if request.shaper.get("kind") not in FASTER_MOVES or request.maneuver.get("kind") != "straight_line":
        return 1.0, {}
    for share in SLOWER_SHARES:
        slower = {key: share * request.maneuver[key] for key in ("speed", "acceleration")}
        try:
            _plan(rig, replace(request, maneuver={**request.maneuver, **slower}))
        except ManeuverError:
            continue
        return share, {"speed": f"{slower['speed']:.4g} m/s", "acceleration": f"{slower['acceleration']:.4g} m/s^2"}
    return 1.0, {}


def _plan(rig: Rig, request: RunRequest) -> RunPlan:
    maneuver = _maneuver(request.maneuver)
    joints = joint_limits(rig)
    period_s = 1.0 / rig.loop.rate_Hz
    _check_position(joints, request, maneuver.name)
    start = program_start(rig, maneuver, joints, request)
    if request.repeat < 1:
        raise ManeuverError("repeat must be at least 1", value=request.repeat, where=maneuver.name, mend={"--repeat": "1"})
    kind = str(request.maneuver["kind"])
    pieces = PIECES[kind](maneuver, Ground(joints, rig.arm.hub_offset_m, start))
    choice = ShaperChoice.from_content(request.shaper)
    planned = tip = tip_peaks(rig, pieces, period_s)
    if choice.kind in FASTER_MOVES:
        _make_faster(pieces, rig, choice, request.planning)
        tip = tip_peaks(rig, pieces, period_s)
    allowed = _allowed(joints, kind, start)
    check_program(pieces, allowed, period_s, maneuver.name, _advice(rig, maneuver, joints))
    check_volts(pieces, rig, joints, period_s, maneuver.name)
    approach = _approach(joints, request, start, maneuver.name)
    peaks = program_peaks([*approach, *pieces], joints, period_s)
    setup = set_up_shaper(rig, choice, _extensions(joints, pieces, peaks))
    told = checked_tip(rig, planned, tip, [peak.rate for peak in peaks], maneuver.name)
    plan = _run_plan(request, Program([*approach, *repeated(pieces, request.repeat, joints)]), setup, joints, peaks, told)
    _check_shaped(rig, replace(plan, program=Program([*approach, *pieces])), allowed, maneuver.name)
    return plan


def _run_plan(
    request: RunRequest,
    program: Program,
    setup: ShaperSetup,
    joints: tuple[JointLimits, ...],
    peaks: tuple[Peaks, ...],
    tip: TipMotion | None,
) -> RunPlan:
    """The checked pieces as one run."""
    first = program.at(0.0, 0)[0]
    motion_end = max((segment.end_s for segment in program.segments() if segment.kind == "move"), default=0.0)
    return RunPlan(request, program, setup, tuple(joint.name for joint in joints), first, motion_end, setup.build().flush_s, peaks, tip)


def _make_faster(pieces: list[Piece], rig: Rig, choice: ShaperChoice, planning: int) -> None:
    if choice.kind == "zero_delay":
        correct_moves(pieces, rig, choice, planning)
    else:
        smooth_moves(pieces)


def _maneuver(content: dict[str, Any]) -> Maneuver:
    try:
        return maneuver_from_content(content)
    except ValidationError as error:
        first = error.errors()[0]
        raise ManeuverError(
            f"the maneuver of the run request cannot be used: {first['msg']}",
            where=".".join(str(part) for part in first["loc"]),
            next_step="Load maneuver files with config.loading.load, which names the line.",
        ) from error


def _check_position(joints: tuple[JointLimits, ...], request: RunRequest, where: str) -> None:
    """Where the arm is may be left out; a value that is no number would be near every start."""
    here = request.start_position
    if here and (len(here) != len(joints) or not all(map(isfinite, here))):
        raise ManeuverError(
            "start_position needs a number for every joint", value=list(here), limit=f"{len(joints)} finite values", where=where
        )


def program_start(rig: Rig, maneuver: Maneuver, joints: tuple[JointLimits, ...], request: RunRequest) -> Vector:
    """The joint position the program itself starts from. ManeuverError where nothing says it, or the rig has no such joints."""
    if isinstance(maneuver, StraightLine):
        names = [joint.name for joint in joints]
        if names != ["rotary", "prismatic"]:
            advice = "Take a maneuver of single joints."
            what = "a straight line needs the joints rotary, prismatic"
            raise ManeuverError(what, value=", ".join(names), where=maneuver.name, next_step=advice)
        return inverse(maneuver.x_start_m, maneuver.y0_m, rig.arm.hub_offset_m)
    assert isinstance(maneuver, JointManeuver)
    given = {joint_index(joints, name, maneuver.name): (name, value) for name, value in maneuver.start.items()}
    if len(request.start_position) != len(joints) and len(given) < len(joints):
        raise ManeuverError(
            "the maneuver starts where the arm is, so start_position needs one value for every joint",
            value=len(request.start_position),
            limit=len(joints),
            where=maneuver.name,
        )
    return tuple(
        in_joint_units(given[j][1], joint, "", f"{maneuver.name}, start.{joint.name}") if j in given else request.start_position[j]
        for j, joint in enumerate(joints)
    )


def _allowed(joints: tuple[JointLimits, ...], kind: str, start: Vector) -> tuple[JointLimits, ...]:
    """A jog or hold may begin outside the travel, but go no farther: else an arm that got there could not be brought back."""
    if kind not in ("jog", "hold"):
        return joints
    return tuple(
        replace(joint, travel=(min(joint.travel[0], position), max(joint.travel[1], position)))
        for joint, position in zip(joints, start, strict=True)
    )


def _advice(rig: Rig, maneuver: Maneuver, joints: tuple[JointLimits, ...]) -> str:
    """What to do about a position outside the travel; for a line the y0 at which all of it lies within the range of the extension."""
    if not isinstance(maneuver, StraightLine):
        return "Choose another start, a smaller amplitude or a shorter distance."
    shortest, longest = (limit + rig.arm.hub_offset_m for limit in joints[1].travel)
    xs, x = [maneuver.x_start_m], maneuver.x_start_m
    for distance in maneuver.moves_m:
        x += distance
        xs.append(x)
    nearest = 0.0 if min(xs) <= 0.0 <= max(xs) else min(map(abs, xs))
    farthest = max(map(abs, xs))
    if farthest >= longest:
        return f"No y0 fits: |x| reaches {farthest:.4f} m, the arm {longest:.4f} m. Choose shorter moves."
    low, high = sqrt(max(0.0, shortest**2 - nearest**2)), sqrt(longest**2 - farthest**2)
    return f"Choose y0 ≥ {low:.4f} m and y0 ≤ {high:.4f} m."


def _approach(joints: tuple[JointLimits, ...], request: RunRequest, start: Vector, where: str) -> list[Piece]:
    """Nothing when the arm is at the start; else a slow synchronised move and a hold, if asked for."""
    here = tuple(request.start_position) or start
    away = [j for j, joint in enumerate(joints) if abs(here[j] - start[j]) > joint.start_tolerance]
    if not away:
        return []
    joint = joints[away[0]]
    if not request.approach:
        raise ManeuverError(
            f"the arm is not at the start of the maneuver: {joint.name} is at {joint.show(here[away[0]])}, "
            f"the start is {joint.show(start[away[0]])}",
            limit=joint.start_tolerance,
            unit=joint.unit,
            where=where,
            next_step="Ask for an approach, or jog there.",
            mend={APPROACH: ""},
        )
    for limits, position in zip(joints, start, strict=True):
        check_position(limits, position, 0.0, where, "Choose another start.")
    speeds = tuple(SLOW_SHARE * limits.rate for limits in joints)
    accelerations = tuple(SLOW_SHARE * limits.acceleration for limits in joints)
    return [JointMove("approach", here, start, speeds, accelerations), Dwell("settle", start, APPROACH_HOLD_S)]


def _extensions(joints: tuple[JointLimits, ...], pieces: list[Piece], peaks: tuple[Peaks, ...]) -> Extensions | None:
    """The approach counts in the range but not in initial and final: a shaper is tuned for the program."""
    j = extension_index(joints)
    if j is None:
        return None
    first_move = next((piece for piece in pieces if piece.kind == "move"), pieces[0])
    final = first_move.at(first_move.duration_s)[0][j]
    return Extensions(pieces[0].at(0.0)[0][j], final, peaks[j].lowest, peaks[j].highest)


def _check_shaped(rig: Rig, plan: RunPlan, joints: tuple[JointLimits, ...], where: str) -> None:
    """A shaper that can overshoot is run through one pass of the program."""
    setup = plan.shaper
    if setup.keeps_bounds:
        return
    if plan.program.duration_s > LONGEST_SHAPED_S:
        raise ManeuverError(
            f"one pass of the program is too long for the shaper {setup.kind}, which has to be run through beforehand",
            value=f"{plan.program.duration_s:.0f}",
            limit=f"{LONGEST_SHAPED_S:.0f}",
            unit="s",
            where=where,
            next_step="Use repeat, or the shaper zvd, ei or none.",
        )
    for cycle in predict(rig, plan):
        for joint, position, rate in zip(joints, cycle.reference, cycle.reference_rate, strict=True):
            low, high = joint.travel
            if abs(rate) > 1.001 * joint.rate or not low - 1e-6 <= position <= high + 1e-6:
                raise ManeuverError(
                    f"after shaping with {setup.kind}, {joint.name} leaves its limits at t = {cycle.t_s:.2f} s: "
                    f"{joint.show(position)}, {rate:.4g} {joint.unit}/s",
                    limit=f"{joint.show(low)} to {joint.show(high)}, {joint.rate:.4g} {joint.unit}/s",
                    where=where,
                    next_step="Choose another shaper or a slower maneuver.",
                )
