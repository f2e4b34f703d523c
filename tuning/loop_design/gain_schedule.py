"""How much more gain the rotary joint tolerates where the arm is shorter: the same demands as for one design, at one extension at a time.

A fixed design is limited by the worst place of the workspace. At every other one its gain may rise until a margin or the damping of
a link mode, at that extension and with every payload, is used up.
"""

from __future__ import annotations

from dataclasses import replace

from config.schema.rig import Rig
from tuning.linear.closed_loop import Servo
from tuning.loop_design.arm_design import problem_at
from tuning.loop_design.lag_lead_design import DesignProblem, evaluate
from tuning.loop_design.workspace import extension_m

PLACES = 9  # evenly over the travel
LARGEST_FACTOR = 6.0
HALVINGS = 8


def gain_schedule(rig: Rig, problem: DesignProblem, servo: Servo) -> list[tuple[float, float]]:
    """(extension in m, factor on the gain): the largest that keeps every demand there; 1 where the servo itself does not."""
    extensions = [extension_m(rig, k / (PLACES - 1)) for k in range(PLACES)]
    return [(extension, _largest_factor(problem_at(problem, rig, extension), servo)) for extension in extensions]


def _largest_factor(problem: DesignProblem, servo: Servo) -> float:
    low, high = 1.0, LARGEST_FACTOR
    for _ in range(HALVINGS):
        middle = (low * high) ** 0.5
        if keeps(problem, replace(servo, gain=servo.gain * middle)):
            low = middle
        else:
            high = middle
    return low


def keeps(problem: DesignProblem, servo: Servo) -> bool:
    """Whether a servo keeps every margin and the damping demanded."""
    found, demands = evaluate(problem, servo), problem.demands
    return (
        found.worst.gain_margin_dB >= demands.gain_margin_dB
        and found.worst.phase_margin_deg >= demands.phase_margin_deg
        and found.worst.sensitivity_peak <= demands.sensitivity_peak
        and (found.least_damping is None or found.least_damping >= problem.least_damping)
    )
