"""The design problem of a single hydraulic axis: over its stroke, sliding slowly and fast, both ways, and over the family's ±20 % of gain.

The oil columns are softest near the middle of the stroke, and the valve damps least where it is hardly open. Dry friction holds the
axis at rest, and does not damp it while it slides one way; so an axis with friction is judged where it slides.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import product

import numpy as np

from config.errors import ManeuverError
from config.schema.rig import Rig
from tuning.arrays import Complexes, Floats
from tuning.linear.closed_loop import Servo, least_damping, sampled_loop
from tuning.linear.family import GAINS
from tuning.linear.linear_arm import LinearArm
from tuning.linear.linear_axis import is_hydraulic_axis, linear_axis
from tuning.linear.pace import pace_of
from tuning.loop_design.lag_lead_design import Demands, DesignProblem, at_pace
from tuning.variants import plant_of

SHARES = (0.0, 0.5, 1.0)  # of the travel
OPENINGS = (-0.3, -0.03, 0.03, 0.3)  # of the spool's stroke
DELAY_CYCLES = 1.5  # of the margins: half a hold and one sample
DELAY_PERIODS = 1  # of the sampled loop


def axis_problem(rig: Rig, demands: Demands | None = None) -> DesignProblem:
    """Plants in m or rad per V. ManeuverError for a rig without a hydraulic axis."""
    if not is_hydraulic_axis(rig):
        advice = "Tune an electric drive by hand; a hydraulic axis with its plant is what `longreach new-rig --kind cylinder` writes."
        raise ManeuverError("the design needs a hydraulic axis and its plant", value=rig.arm.kind, where=rig.name, next_step=advice)
    (joint,) = rig.joints.values()
    low, high = joint.travel
    openings = OPENINGS if any(entry.effect == "coulomb_friction" for entry in plant_of(rig).effects) else (0.0, *OPENINGS)
    axes = [linear_axis(rig, low + share * (high - low), opening) for share, opening in product(SHARES, openings)]
    period_s = 1.0 / rig.loop.rate_Hz
    pace = pace_of(rig, linear_axis(rig, 0.5 * (low + high)))
    plants = tuple(partial(position_response, axis, gain, DELAY_CYCLES * period_s) for axis, gain in product(axes, GAINS))
    damping = partial(worst_axis_damping, axes, period_s)
    return DesignProblem(plants, demands or at_pace(pace), damping=damping, pace=pace)


def position_response(axis: LinearArm, gain: float, delay_s: float, omega: Floats) -> Complexes:
    """Position per V with dead time, at frequencies in rad/s."""
    return np.asarray(gain * axis.response(omega, axis.position) * np.exp(-1j * omega * delay_s))


def worst_axis_damping(axes: Sequence[LinearArm], period_s: float, servo: Servo) -> float:
    """Smallest damping ratio of any mode of the sampled loop, over all places and gains; negative where one is unstable."""
    scaled = [Servo(servo.gain * gain, servo.sections) for gain in GAINS]
    return min(least_damping(sampled_loop(axis, each, period_s, DELAY_PERIODS), period_s) for axis, each in product(axes, scaled))
