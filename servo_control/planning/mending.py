"""What of a refused maneuver to change, and to which values, so that the rig can run it.

Three changes are tried, one after the other, and what comes out is planned before it is told:

- a start outside the travel moves to its middle, a line's distance from the hub to the nearest that fits;
- the size (amplitude, distance, step, a line's moves) shrinks by the share that fits. Positions about the start are proportional to it,
  and of an excitation rates, accelerations and volts too;
- the pace falls: to the joint's own limits, and of a line as a whole: with k times the speed and k² times the acceleration of a
  trapezoid every rate is k times and every acceleration k² times what it was.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import accumulate
from math import sqrt, tan
from typing import Any

from config.errors import LongreachError, ManeuverError
from config.schema.maneuver import JointManeuver, JointSteps, Maneuver, StraightLine, maneuver_from_content
from config.schema.rig import Rig
from servo_control.path.joint_limits import JointLimits, joint_index, joint_limits
from servo_control.path.maneuver_pieces import PIECES, Ground
from servo_control.path.pieces import Piece, Vector
from servo_control.planning.plan_checks import EXCITATIONS, check_band, program_peaks, program_volts
from servo_control.planning.planning import APPROACH, plan_run, program_start
from servo_control.planning.run_plan import RunPlan
from servo_control.planning.run_request import RunRequest
from servo_control.planning.tip_motion import tip_peaks

WITHIN = 0.998  # of a limit: values are told with four digits
_SIZE = {
    "jog": "by", "fast_strokes": "by", "slow_triangle": "amplitude", "staircase": "step", "sine_sweep": "amplitude",
    "multisine": "amplitude",
}  # fmt: skip
_PACE = {"speed": 1, "rate": 1, "acceleration": 2}  # key → power of k
_PACE_UNIT = {"speed": "/s", "rate": "/s", "acceleration": "/s^2"}
Changes = dict[str, Any]  # key of the maneuver → quantities as a file has them: "0.31 m"


def plan_or_mend(rig: Rig, request: RunRequest) -> RunPlan:
    """`plan_run` for a user's own maneuver: its ManeuverError names what to change, where a change is known that is enough."""
    try:
        check_band(request.maneuver, rig)
        return plan_run(rig, request)
    except ManeuverError as error:
        error.refusal = replace(error.refusal, mend=error.refusal.mend or mended(rig, request))
        raise


def mended(rig: Rig, request: RunRequest) -> dict[str, str]:
    """Key → value with its unit, of all that has to change, and `--approach` where the arm is elsewhere; empty where no such change is
    known, or none is enough."""
    changes: Changes = {}
    with suppress(LongreachError, ArithmeticError, ValueError):
        for change in (_place, _size, _pace):
            changes |= change(_Asked(rig, replace(request, maneuver={**request.maneuver, **changes})))
        how = _planned(rig, replace(request, maneuver={**request.maneuver, **changes}))
        return {key: _text(value) for key, value in changes.items()} | how
    return {}


def _planned(rig: Rig, request: RunRequest) -> dict[str, str]:
    """What else to ask for, so that it can be planned. ManeuverError where it cannot."""
    try:
        plan_run(rig, request)
    except ManeuverError as error:
        if APPROACH not in error.refusal.mend:
            raise
        plan_run(rig, replace(request, approach=True))
        return {APPROACH: ""}
    return {}


class _Asked:
    """A maneuver on its rig, as it is written."""

    def __init__(self, rig: Rig, request: RunRequest) -> None:
        self.rig, self.content = rig, request.maneuver
        self.maneuver: Maneuver = maneuver_from_content(request.maneuver)
        self.kind = str(request.maneuver["kind"])
        self.joints = joint_limits(rig)
        self.start: Vector = program_start(rig, self.maneuver, self.joints, request)

    def pieces(self) -> list[Piece]:
        return PIECES[self.kind](self.maneuver, Ground(self.joints, self.rig.arm.hub_offset_m, self.start))

    @property
    def period_s(self) -> float:
        return 1.0 / self.rig.loop.rate_Hz


def _place(asked: _Asked) -> Changes:
    if isinstance(asked.maneuver, StraightLine):
        return _line_place(asked, asked.maneuver)
    assert isinstance(asked.maneuver, JointManeuver)
    stated = asked.maneuver.start
    out = [joint for joint, at in zip(asked.joints, asked.start, strict=True) if joint.name in stated and not _is_inside(joint, at)]
    middles = {joint.name: _quantity(0.5 * sum(joint.travel), joint.unit) for joint in out}
    return {"start": {**stated, **middles}} if out else {}


def _line_place(asked: _Asked, line: StraightLine) -> Changes:
    """y0 where the line lies within reach and turn of the arm; shorter moves where it is too long for any."""
    rotary, prismatic = asked.joints
    shortest, longest = (limit + asked.rig.arm.hub_offset_m for limit in prismatic.travel)
    turn = tan(min(-rotary.travel[0], rotary.travel[1], 1.57))
    xs = list(accumulate(line.moves_m, initial=line.x_start_m))
    nearest = 0.0 if min(xs) <= 0.0 <= max(xs) else min(map(abs, xs))
    farthest = max(map(abs, xs))
    low = max(sqrt(max(0.0, shortest**2 - nearest**2)), farthest / turn)
    high = sqrt(max(0.0, longest**2 - farthest**2))
    if low <= high:
        y0_m = min(max(line.y0_m, low / WITHIN), high * WITHIN)
        return {} if low <= line.y0_m <= high else {"y0": _quantity(y0_m, "m")}
    y0_m = min(max(line.y0_m, shortest / WITHIN), sqrt(0.5) * longest)
    reach_m = WITHIN * min(sqrt(longest**2 - y0_m**2), y0_m * turn)
    share = (reach_m - abs(line.x_start_m)) / max(abs(x - line.x_start_m) for x in xs)
    moves = {"moves": [_quantity(share * distance, "m") for distance in line.moves_m]}
    return moves if y0_m == line.y0_m else {"y0": _quantity(y0_m, "m"), **moves}


def _size(asked: _Asked) -> Changes:
    if isinstance(asked.maneuver, JointSteps):
        return _steps(asked, asked.maneuver)
    key = _SIZE.get(asked.kind)
    share = min(_shares(asked), default=1.0) if key else 1.0
    return {key: _scaled(asked, key, WITHIN * share)} if key and share < 1.0 else {}


def _shares(asked: _Asked) -> Iterator[float]:
    """How much of the size each limit leaves, of those that are exceeded."""
    pieces = asked.pieces()
    peaks = program_peaks(pieces, asked.joints, asked.period_s)
    volts = program_volts(pieces, asked.joints, asked.period_s)
    for joint, peak, at, peak_V in zip(asked.joints, peaks, asked.start, volts, strict=True):
        low, high = joint.travel
        ratios = [(high - at, peak.highest - at), (at - low, at - peak.lowest)]
        if asked.kind in EXCITATIONS:
            ratios += [(joint.rate, peak.rate), (joint.acceleration, peak.acceleration)]
        held_V = asked.rig.joints[joint.name].following_error_limit * abs(asked.rig.servo[joint.name].gain)
        ratios.append((min(joint.command_V, held_V), peak_V))
        yield from (allowed / asks for allowed, asks in ratios if asks > allowed)


def _steps(asked: _Asked, maneuver: JointSteps) -> Changes:
    """Every step within its joint's limits."""
    at, steps = list(asked.start), []
    for step in maneuver.steps:
        j = joint_index(asked.joints, step.joint, maneuver.name)
        joint, written = asked.joints[j], step.model_dump(mode="json", by_alias=True, exclude_none=True)
        goal = _number(step.to) if step.to is not None else at[j] + _number(step.by or 0.0)
        held = _inside(joint, goal)
        if held != goal:
            written |= {"to": _quantity(held, joint.unit)} if step.to is not None else {"by": _quantity(held - at[j], joint.unit)}
        for key, limit in (("speed", joint.rate), ("acceleration", joint.acceleration)):
            if key in written and _number(written[key]) > limit:
                written[key] = _quantity(WITHIN * limit, joint.unit + _PACE_UNIT[key])
        at[j] = held
        steps.append(written)
    before = [step.model_dump(mode="json", by_alias=True, exclude_none=True) for step in maneuver.steps]
    return {} if steps == before else {"steps": steps}


def _pace(asked: _Asked) -> Changes:
    """Of the speeds and accelerations that the maneuver states."""
    stated = [key for key in _PACE if asked.content.get(key) is not None]
    if not stated or asked.content.get("on") == "command":
        return {}
    if not isinstance(asked.maneuver, StraightLine):
        joint = asked.joints[joint_index(asked.joints, str(asked.content["joint"]), asked.maneuver.name)]
        limits = {key: joint.acceleration if key == "acceleration" else joint.rate for key in stated}
        shares = {key: limits[key] / max(_number(asked.content[key]), 1e-12) for key in stated}
        return {key: _scaled(asked, key, WITHIN * share) for key, share in shares.items() if share < 1.0}
    k = _line_pace(asked)
    return {key: _scaled(asked, key, (WITHIN * k) ** _PACE[key]) for key in stated} if k < 1.0 else {}


def _line_pace(asked: _Asked) -> float:
    """The k of the whole line: its rates and accelerations belong to no joint alone."""
    pieces = asked.pieces()
    tip, limit_mps2 = tip_peaks(asked.rig, pieces, asked.period_s), asked.rig.interlocks.tip_acceleration_max_m_per_s2
    shares = [limit_mps2 / tip.acceleration_mps2] if tip and tip.acceleration_mps2 > 0.0 and limit_mps2 is not None else []
    for joint, peak in zip(asked.joints, program_peaks(pieces, asked.joints, asked.period_s), strict=True):
        shares += [(joint.rate / peak.rate) ** 2] if peak.rate > 0.0 else []
        shares += [joint.acceleration / peak.acceleration] if peak.acceleration > 0.0 else []
    return sqrt(min(shares, default=1.0))


def _scaled(asked: _Asked, key: str, share: float) -> str:
    written = asked.content[key]
    if asked.content.get("on") == "command":
        unit = "V"
    elif "joint" in asked.content:
        unit = asked.joints[joint_index(asked.joints, str(asked.content["joint"]), asked.maneuver.name)].unit
    else:
        unit = "m"
    return _quantity(share * _number(written), unit + _PACE_UNIT.get(key, ""))


def _is_inside(joint: JointLimits, position: float) -> bool:
    return joint.travel[0] <= position <= joint.travel[1]


def _inside(joint: JointLimits, position: float) -> float:
    """The position, or where it is outside the travel one just within."""
    low, high = joint.travel
    rim = (1.0 - WITHIN) * (high - low)
    return position if _is_inside(joint, position) else min(max(position, low + rim), high - rim)


def _number(written: float | str) -> float:
    return float(written.partition(" ")[0]) if isinstance(written, str) else float(written)


def _quantity(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}"


def _text(value: Any) -> str:
    """As one value of a maneuver file."""
    if isinstance(value, list):
        return f"[{', '.join(map(_text, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {_text(each)}' for key, each in value.items())}}}"
    return str(value)
