"""Gravity in a tilted plane of motion: g sin(tilt) along the slope on every mass; the far end (rotary 0) points up.

On an arm it turns by (moment) sin θ, pushes the tube inwards by weight · cos θ and bends the link; on a single axis it is a constant
force.
"""

from __future__ import annotations

import math

from config.effects_joint import Gravity
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import C, J

STANDARD_GRAVITY = 9.80665  # m/s²


def _along_slope(tilt_rad: float) -> float:
    return STANDARD_GRAVITY * math.sin(tilt_rad)


EFFECT = Effect(
    entry=Gravity,
    writes=(
        Write("tilt", C.GRAVITY, convert=_along_slope),
        Write("unbalance", J.UNBALANCE),
    ),
    neutral={"tilt": 0.0},
    fingerprint="A pressure difference is needed to hold still, and it depends on the position, not on the velocity.",
    look_alikes={
        "valve_null_bias": "hold still at three positions: a bias drifts without a pressure difference",
        "cross_leakage": "leakage drifts in proportion to the pressure difference",
        "asymmetric_friction": "friction vanishes at rest",
    },
)
