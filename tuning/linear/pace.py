"""How fast a joint is beside the paper's: the ratio of the frequencies at which it lags its command by 180 degrees.

There stability ends without a compensator. The limits of a search, and the waves of an identification, were set for the paper's joint and
move with it.
"""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from config.errors import ManeuverError
from config.schema.rig import Rig
from tuning.eq4 import PRODUCT_PER_S2
from tuning.linear.linear_arm import LinearArm

SPAN_HZ = (0.05, 500.0, 2000)


def pace_of(rig: Rig, joint: LinearArm) -> float:
    """How many times as fast as the paper's joint. ManeuverError when it never lags by 180 degrees."""
    return _phase_crossover_rad_per_s(rig, joint) / sqrt(PRODUCT_PER_S2)


def _phase_crossover_rad_per_s(rig: Rig, joint: LinearArm) -> float:
    omega = 2.0 * pi * np.geomspace(*SPAN_HZ)
    phase = np.unwrap(np.angle(joint.response(omega, joint.position)))
    beyond = np.flatnonzero(phase < -pi)
    if not len(beyond):
        low, high, _ = SPAN_HZ
        raise ManeuverError(
            "the joint never lags by 180 degrees: no gain of it is limited",
            limit=f"{low:g} to {high:g}",
            unit="Hz",
            where=rig.name,
            next_step="Look at plant.joints and its valve_lag.",
        )
    return float(omega[beyond[0]])
