"""Maneuvers that suit one axis: a jog to find the way, steps for the servo, a slow triangle for friction, fast strokes for the supply."""

from __future__ import annotations

from tuning.new_rig.axis import Axis
from tuning.new_rig.rig_text import length


def maneuver_texts(axis: Axis, name: str, joint: str) -> dict[str, str]:
    """File stem → text."""
    middle, stroke = length(axis, 0.5 * (axis.low + axis.high)), axis.stroke
    start = f"start: {{{joint}: {middle}}}"
    step, half = length(axis, 0.1 * stroke), length(axis, 0.3 * stroke)
    bodies = {
        "jog": ("A small slow move, for finding the way", [f"joint: {joint}", f"by: {length(axis, 0.02 * stroke)}"]),
        "joint_steps": (
            "Steps about mid stroke: lag, overshoot, settling",
            [start, "steps:", f"  - {{joint: {joint}, by: {step}, hold: 2 s}}", f"  - {{joint: {joint}, to: {middle}, hold: 2 s}}"],
        ),
        "slow_triangle": (
            "So slow that friction and the valve's null remain",
            [start, f"joint: {joint}", "on: reference", f"amplitude: {step}", f"rate: {length(axis, 0.02 * stroke, '/s')}", "cycles: 2"],
        ),
        "fast_strokes": (
            "As fast as the limits allow: supply droop, saturation",
            [start, f"joint: {joint}", f"by: {half}", "strokes: 4", "hold: 1 s"],
        ),
    }
    return {f"{name}_{kind}": maneuver_text(f"{name}_{kind}", kind, about, lines) for kind, (about, lines) in bodies.items()}


def maneuver_text(name: str, kind: str, about: str, lines: list[str]) -> str:
    """A whole maneuver file."""
    return "\n".join(["longreach: maneuver/1", f"name: {name}", f'description: "{about}"', f"kind: {kind}", *lines]) + "\n"
