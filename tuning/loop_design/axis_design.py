"""The design problem of a single hydraulic axis: over its stroke, sliding slowly and fast, both ways, and over the family's ±20 % of gain.

The oil columns are softest near the middle of the stroke, and the valve damps least where it is hardly open. Dry friction does not damp
an axis while it slides one way; at rest its bristles hold it. So an axis with friction must keep its margins where it slides, with the
slope of its friction curve, and its modes must be damped there and where it is held.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from config.errors import ManeuverError
from config.schema.rig import Rig
from tuning.arrays import Complexes, Floats
from tuning.linear.closed_loop import Servo, least_damping, sampled_loop
from tuning.linear.family import GAINS
from tuning.linear.hydraulic_axis import is_hydraulic_axis
from tuning.linear.linear_arm import LinearArm
from tuning.linear.linear_axis import has_bristles, linear_axis
from tuning.linear.pace import pace_of
from tuning.loop_design.lag_lead_design import Demands, DesignProblem, at_pace
from tuning.loop_design.rotary_joint import DesignedJoint

SHARES = (0.0, 0.5, 1.0)  # of the travel
OPENINGS = (-0.3, -0.03, 0.03, 0.3)  # of the spool's stroke
DELAY_CYCLES = 1.5  # of the margins: half a hold and one sample
DELAY_PERIODS = 1  # of the sampled loop


@dataclass(frozen=True, slots=True, eq=False)
class AxisPlace:
    """The axis linearised at a position (m or rad), sliding with its spool open by a share of its stroke, or held by its friction."""

    arm: LinearArm
    position: float
    opening: float
    held: bool = False


def axis_places(rig: Rig) -> list[AxisPlace]:
    """Where a servo must do. ManeuverError for a rig without a hydraulic axis."""
    if not is_hydraulic_axis(rig):
        advice = "Tune an electric drive by hand; a hydraulic axis with its plant is what `longreach new-rig --kind cylinder` writes."
        raise ManeuverError("the design needs a hydraulic axis and its plant", value=rig.arm.kind, where=rig.name, next_step=advice)
    (joint,) = rig.joints.values()
    low, high = joint.travel
    found = []
    for share, opening in product(SHARES, (0.0, *OPENINGS)):
        position = low + share * (high - low)
        axis = linear_axis(rig, position, opening, friction=True)
        found.append(AxisPlace(axis, position, opening, held=not opening and has_bristles(axis)))
    return found


def axis_joint(rig: Rig) -> DesignedJoint:
    """At the middle of its travel without friction: the loop in which its friction may hunt, and its pace."""
    (joint,) = rig.joints.values()
    axis = linear_axis(rig, 0.5 * (joint.travel[0] + joint.travel[1]))
    return DesignedJoint(axis.system()[0, 0], pace_of(rig, axis))


def axis_problem(rig: Rig, demands: Demands | None = None) -> DesignProblem:
    """Plants in m or rad per V. ManeuverError for a rig without a hydraulic axis."""
    places = axis_places(rig)
    period_s, pace = 1.0 / rig.loop.rate_Hz, axis_joint(rig).pace
    sliding = [place.arm for place in places if not place.held]
    plants = tuple(partial(position_response, axis, gain, DELAY_CYCLES * period_s) for axis, gain in product(sliding, GAINS))
    damping = partial(worst_axis_damping, [place.arm for place in places], period_s)
    return DesignProblem(plants, demands or at_pace(pace), damping=damping, pace=pace)


def position_response(axis: LinearArm, gain: float, delay_s: float, omega: Floats) -> Complexes:
    """Position per V with dead time, at frequencies in rad/s."""
    return np.asarray(gain * axis.response(omega, axis.position) * np.exp(-1j * omega * delay_s))


def worst_axis_damping(axes: Sequence[LinearArm], period_s: float, servo: Servo) -> float:
    """Smallest damping ratio of any mode of the sampled loop, over all places and gains; negative where one is unstable."""
    scaled = [Servo(servo.gain * gain, servo.sections) for gain in GAINS]
    return min(least_damping(sampled_loop(axis, each, period_s, DELAY_PERIODS), period_s) for axis, each in product(axes, scaled))
