"""What the rig file's plant says that an identification of a single hydraulic axis measures: load and oil at rest, without friction."""

from __future__ import annotations

from math import isfinite, pi
from typing import NamedTuple

import numpy as np

from config.schema.rig import Rig
from tuning.linear.closed_loop import modes
from tuning.linear.linear_axis import linear_axis
from tuning.linear.pace import pace_of

SLOW_HZ = 0.3  # of an axis with the paper's pace: an integrator yet


class BelievedAxis(NamedTuple):
    """m or rad per V·s; frequency and damping None where leakage lets nothing ring."""

    velocity_gain: float
    natural_Hz: float | None
    damping_ratio: float | None


def believed_axis(rig: Rig, position: float, oil_C: float) -> BelievedAxis:
    """At a position (m or rad). `oil_C` NaN: that of the rig file."""
    temperature_C = oil_C if isfinite(oil_C) else None
    axis = linear_axis(rig, position, 0.0, temperature_C)
    slow = np.array([2.0 * pi * SLOW_HZ * pace_of(rig, axis)])
    gain = float(abs(axis.response(slow, axis.position)[0]) * slow[0])
    found = modes(linear_axis(rig, position, 0.0, temperature_C, valve_lag=False).a)
    rings = np.flatnonzero(found.damping_ratio < 1.0 - 1e-9)
    if not len(rings):
        return BelievedAxis(gain, None, None)
    return BelievedAxis(gain, float(found.frequency_Hz[rings[-1]]), float(found.damping_ratio[rings[-1]]))
