"""From a maneuver file to the pieces of its program, one function a kind. Nothing is checked against the workspace here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from config.errors import ManeuverError
from config.schema.maneuver import FastStrokes, Hold, Jog, JointSteps, Multisine, SineSweep, SlowTriangle, Staircase, StraightLine
from servo_control.link.kinematics import inverse
from servo_control.path.joint_limits import SLOW_SHARE, JointLimits, in_joint_units, in_volts, joint_index
from servo_control.path.multisine import Multisine as MultisineWave
from servo_control.path.multisine import odd_harmonics
from servo_control.path.pieces import Dwell, Excited, JointMove, LineMove, Piece, Vector
from servo_control.path.trajectory import Trapezoid
from servo_control.path.waves import Stairs, Sweep, Triangle, Wave


@dataclass(frozen=True, slots=True)
class Ground:
    """What a maneuver is planned on: the joints, the hub offset and the position it starts from."""

    joints: tuple[JointLimits, ...]
    hub_offset_m: float
    start: Vector


def straight_line(m: StraightLine, ground: Ground) -> list[Piece]:
    pieces: list[Piece] = []
    x = m.x_start_m
    for number, distance in enumerate(m.moves_m, start=1):
        path = Trapezoid(distance, m.speed_m_per_s, m.acceleration_m_per_s2)
        pieces.append(LineMove(f"move {number}", x, path, m.y0_m, ground.hub_offset_m))
        x += distance
        if m.hold_s > 0.0:
            pieces.append(Dwell(f"hold {number}", inverse(x, m.y0_m, ground.hub_offset_m), m.hold_s))
    return pieces


def joint_steps(m: JointSteps, ground: Ground) -> list[Piece]:
    pieces: list[Piece] = []
    here = ground.start
    for number, step in enumerate(m.steps, start=1):
        j = joint_index(ground.joints, step.joint, f"{m.name}, step {number}")
        where = f"{m.name}, step {number}"
        goal = in_joint_units(step.to, ground.joints[j], "", f"{where}, to") if step.to is not None else here[j]
        goal += in_joint_units(step.by, ground.joints[j], "", f"{where}, by") if step.by is not None else 0.0
        pieces += _move_and_hold(number, here, _with(here, j, goal), _Pace(ground, j, step.speed, step.acceleration, where), step.hold_s)
        here = _with(here, j, goal)
    return pieces


def jog(m: Jog, ground: Ground) -> list[Piece]:
    j = joint_index(ground.joints, m.joint, m.name, "joint")
    joint = ground.joints[j]
    speed = m.speed if m.speed is not None else SLOW_SHARE * joint.rate
    goal = ground.start[j] + in_joint_units(m.by, joint, "", f"{m.name}, by")
    return _move_and_hold(
        1, ground.start, _with(ground.start, j, goal), _Pace(ground, j, speed, SLOW_SHARE * joint.acceleration, m.name), 0.0
    )


def hold(m: Hold, ground: Ground) -> list[Piece]:
    return [Dwell("hold 1", ground.start, m.duration_s)]


def fast_strokes(m: FastStrokes, ground: Ground) -> list[Piece]:
    j = joint_index(ground.joints, m.joint, m.name, "joint")
    far = _with(ground.start, j, ground.start[j] + in_joint_units(m.by, ground.joints[j], "", f"{m.name}, by"))
    pace = _Pace(ground, j, m.speed, m.acceleration, m.name)
    pieces: list[Piece] = []
    here = ground.start
    for number in range(1, m.strokes + 1):
        there = far if number % 2 else ground.start
        pieces += _move_and_hold(number, here, there, pace, m.hold_s)
        here = there
    return pieces


def slow_triangle(m: SlowTriangle, ground: Ground) -> list[Piece]:
    j = joint_index(ground.joints, m.joint, m.name, "joint")
    joint = ground.joints[j]
    on_command = m.on == "command"
    amplitude = (
        in_volts(m.amplitude, "", f"{m.name}, amplitude") if on_command else in_joint_units(m.amplitude, joint, "", f"{m.name}, amplitude")
    )
    rate = in_volts(m.rate, "/s", f"{m.name}, rate") if on_command else in_joint_units(m.rate, joint, "/s", f"{m.name}, rate")
    _check_triangle(amplitude, rate, "V" if on_command else joint.unit, m.name)
    if on_command:
        return [_on_command("triangle", ground, j, Triangle(amplitude, rate, m.cycles))]
    pace = _Pace(ground, j, rate, None, m.name)
    pieces: list[Piece] = []
    here = ground.start
    for number, offset in enumerate((amplitude, -amplitude) * m.cycles + (0.0,), start=1):
        there = _with(here, j, ground.start[j] + offset)
        pieces += _move_and_hold(number, here, there, pace, 0.0)
        here = there
    return pieces


def _check_triangle(amplitude: float, rate: float, unit: str, where: str) -> None:
    if amplitude == 0.0:
        raise ManeuverError("a triangle needs an amplitude", value="0", limit="not 0", unit=unit, where=f"{where}, amplitude")
    if rate <= 0.0:
        advice = "Give the slope without a sign; a negative amplitude goes down first."
        raise ManeuverError(
            "a triangle needs a slope", value=f"{rate:g}", limit="> 0", unit=f"{unit}/s", where=f"{where}, rate", next_step=advice
        )


def staircase(m: Staircase, ground: Ground) -> list[Piece]:
    j = joint_index(ground.joints, m.joint, m.name, "joint")
    if m.on == "command":
        return [_on_command("stairs", ground, j, Stairs(in_volts(m.step, "", f"{m.name}, step"), m.steps, m.hold_s))]
    step = in_joint_units(m.step, ground.joints[j], "", f"{m.name}, step")
    pieces: list[Piece] = []
    here = ground.start
    for number, level in enumerate((*range(1, m.steps + 1), *range(m.steps - 1, -1, -1)), start=1):
        there = _with(here, j, ground.start[j] + level * step)
        pieces += _move_and_hold(number, here, there, _Pace(ground, j, None, None, m.name), m.hold_s)
        here = there
    return pieces


def sine_sweep(m: SineSweep, ground: Ground) -> list[Piece]:
    j = joint_index(ground.joints, m.joint, m.name, "joint")
    amplitude = (
        in_volts(m.amplitude, "", f"{m.name}, amplitude")
        if m.on == "command"
        else in_joint_units(m.amplitude, ground.joints[j], "", f"{m.name}, amplitude")
    )
    wave = Sweep(amplitude, m.from_Hz, m.to_Hz, m.duration_s, m.fade_s, logarithmic=m.law == "logarithmic")
    return [Excited("sweep", ground.start, j, wave, on_command=m.on == "command")]


def multisine(m: Multisine, ground: Ground) -> list[Piece]:
    j = joint_index(ground.joints, m.joint, m.name, "joint")
    amplitude = (
        in_volts(m.amplitude, "", f"{m.name}, amplitude")
        if m.on == "command"
        else in_joint_units(m.amplitude, ground.joints[j], "", f"{m.name}, amplitude")
    )
    harmonics = odd_harmonics(m.from_Hz, m.to_Hz, m.period_s, m.lines)
    wave = MultisineWave(amplitude, harmonics, m.period_s, m.periods, m.fade_s, m.seed, m.crest_limit)
    return [Excited("multisine", ground.start, j, wave, on_command=m.on == "command")]


PIECES: dict[str, Callable[[Any, Ground], list[Piece]]] = {
    "straight_line": straight_line,
    "joint_steps": joint_steps,
    "jog": jog,
    "hold": hold,
    "fast_strokes": fast_strokes,
    "slow_triangle": slow_triangle,
    "staircase": staircase,
    "sine_sweep": sine_sweep,
    "multisine": multisine,
}


class _Pace:
    """Speeds and accelerations of a move of one joint; what the file leaves out is the joint's limit."""

    __slots__ = ("accelerations", "speeds")

    def __init__(self, ground: Ground, j: int, speed: float | str | None, acceleration: float | str | None, where: str) -> None:
        joint = ground.joints[j]
        v = joint.rate if speed is None else in_joint_units(speed, joint, "/s", f"{where}, speed")
        a = joint.acceleration if acceleration is None else in_joint_units(acceleration, joint, "/s^2", f"{where}, acceleration")
        for word, value, per in (("speed", v, "/s"), ("acceleration", a, "/s^2")):
            if value <= 0.0:
                what, unit = f"the {word} of {joint.name} must be above 0", joint.unit + per
                raise ManeuverError(what, value=f"{value:g}", unit=unit, where=where, next_step="Its sign comes from the way.")
        self.speeds = _with(tuple(limits.rate for limits in ground.joints), j, v)
        self.accelerations = _with(tuple(limits.acceleration for limits in ground.joints), j, a)


def _move_and_hold(number: int, here: Vector, there: Vector, pace: _Pace, hold_s: float) -> list[Piece]:
    pieces: list[Piece] = [JointMove(f"move {number}", here, there, pace.speeds, pace.accelerations)]
    if hold_s > 0.0:
        pieces.append(Dwell(f"hold {number}", there, hold_s))
    return pieces


def _on_command(name: str, ground: Ground, j: int, wave: Wave) -> Piece:
    return Excited(name, ground.start, j, wave, on_command=True)


def _with(positions: Vector, j: int, value: float) -> Vector:
    return (*positions[:j], value, *positions[j + 1 :])
