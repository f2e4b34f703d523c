"""Maneuvers that suit an arm: a jog, steps of both joints, slow triangles for friction, fast strokes, and a straight line of the tip."""

from __future__ import annotations

from math import sqrt, tan

from tuning.new_rig.axis import Axis
from tuning.new_rig.maneuver_texts import maneuver_text
from tuning.new_rig.rig_text import length

_INSIDE = 0.05  # of the extension's range, at either end of the line
_LINE_SPEED = 0.5  # of what the slower joint could do
_HOLD_S = 2


def arm_maneuver_texts(rotary: Axis, prismatic: Axis, name: str) -> dict[str, str]:
    """File stem → text."""
    joints = {"rotary": rotary, "prismatic": prismatic}
    middle = {joint: length(axis, 0.5 * (axis.low + axis.high)) for joint, axis in joints.items()}
    start = f"start: {{{', '.join(f'{joint}: {place}' for joint, place in middle.items())}}}"
    steps = [line for joint, axis in joints.items() for line in _steps(joint, axis, middle[joint])]
    bodies = {
        "jog": (
            "jog",
            "A small slow move of the hub, for finding the way",
            ["joint: rotary", f"by: {length(rotary, 0.02 * rotary.stroke)}"],
        ),
        "joint_steps": ("joint_steps", "Steps of both joints about mid stroke: lag, overshoot, settling", [start, "steps:", *steps]),
        "line": ("straight_line", "The tip along a straight line and back: vibration of the link", _line(rotary, prismatic)),
    }
    for joint, axis in joints.items():
        about = [start, f"joint: {joint}"]
        slow = ["on: reference", f"amplitude: {_step(axis)}", f"rate: {length(axis, 0.02 * axis.stroke, '/s')}", "cycles: 2"]
        bodies[f"slow_triangle_{joint}"] = ("slow_triangle", "So slow that friction and the valve's null remain", about + slow)
        fast = [f"by: {length(axis, 0.2 * axis.stroke)}", "strokes: 4", "hold: 1 s"]
        bodies[f"fast_strokes_{joint}"] = ("fast_strokes", "As fast as the limits allow: supply droop, saturation", about + fast)
    return {f"{name}_{stem}": maneuver_text(f"{name}_{stem}", kind, about, lines) for stem, (kind, about, lines) in bodies.items()}


def _step(axis: Axis) -> str:
    return length(axis, 0.05 * axis.stroke)


def _steps(joint: str, axis: Axis, middle: str) -> list[str]:
    return [
        f"  - {{joint: {joint}, by: {_step(axis)}, hold: {_HOLD_S} s}}",
        f"  - {{joint: {joint}, to: {middle}, hold: {_HOLD_S} s}}",
    ]


def _line(rotary: Axis, prismatic: Axis) -> list[str]:
    """From x = -h to +h at y0: both ends and the middle within the travel. The radius is y0 in the middle and √(y0² + h²) at the ends."""
    span = prismatic.stroke
    nearest, farthest = prismatic.low + 4 * _INSIDE * span, prismatic.high - _INSIDE * span
    half = min(0.5 * sqrt(farthest**2 - nearest**2), nearest * tan(min(0.9 * rotary.high, 1.4)))
    y0 = 0.5 * (nearest + sqrt(farthest**2 - half**2))
    speed = _LINE_SPEED * min(rotary.rate_limit * y0, prismatic.rate_limit * sqrt(y0**2 + half**2) / half)
    acceleration = _LINE_SPEED * min(rotary.acceleration_limit * y0, prismatic.acceleration_limit)
    return [
        f"y0: {1e3 * y0:.4g} mm",
        f"moves: [{1e3 * half:.4g} mm, {-2e3 * half:.4g} mm, {1e3 * half:.4g} mm]",
        f"hold: {_HOLD_S} s",
        f"speed: {1e3 * speed:.4g} mm/s",
        f"acceleration: {1e3 * acceleration:.4g} mm/s^2",
    ]
