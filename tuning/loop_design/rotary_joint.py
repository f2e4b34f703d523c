"""The joint that a compensator is searched for: the paper's measured one, or this rig's own, and how fast it is beside the paper's.

The limits of the search (band, corners, frequencies of the sine tests) were set for the paper's joint; for another one they are moved
by its pace.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, radians

import control
import numpy as np

from config.schema.rig import Rig
from tuning.linear.family import GAINS
from tuning.linear.linear_arm import LinearArm
from tuning.linear.pace import pace_of
from tuning.transfer import EQ4

SLOW_HZ = 0.5  # an integrator yet: velocity per volt


@dataclass(frozen=True, slots=True, eq=False)
class DesignedJoint:
    """`system`: V to rad (or m), for the cycles of hunting; `pace`: 1 for the paper's joint, 2 for one that is twice as fast."""

    system: control.TransferFunction | control.StateSpace
    pace: float


def designed_joint(rig: Rig, arm: LinearArm) -> DesignedJoint:
    """Eq 4 where the rig's linear joint, `arm`, has its velocity gain and its pace within the paper's own ±20 %; else that joint itself."""
    pace = pace_of(rig, arm)
    slow = np.array([2.0 * pi * SLOW_HZ * pace])
    gain_ratio = abs(arm.response(slow, arm.position)[0]) / (radians(1.0) * abs(EQ4(1j * slow[0])))
    low, *_, high = GAINS
    if low <= gain_ratio <= high and low <= pace <= high:
        return DesignedJoint(radians(1.0) * EQ4, 1.0)
    return DesignedJoint(arm.system()[0, 0], pace)
