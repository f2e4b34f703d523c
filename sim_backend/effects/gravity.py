"""Gravity in a tilted plane of motion: g sin(tilt) along the slope on every mass; the far end (rotary 0) points up.

On an arm it turns by (moment) sin θ, pushes the tube inwards by weight · cos θ and bends the link. A single sliding axis feels a constant
force, a single turning one unbalance · sin(tilt) sin θ.
"""

from __future__ import annotations

import math
from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, both
from config.schema.effect_entry import JointEntry
from config.schema.section import quantity
from sim_backend.memory.layout import C, J

STANDARD_GRAVITY = 9.80665  # m/s²


class Gravity(JointEntry):
    """The plane of motion is tilted; for an arm one entry at either joint tilts the whole arm."""

    effect: Literal["gravity"]
    tilt_rad: float = quantity("rad", "angle of the plane of motion to the horizontal, its far end (rotary 0) up", low=-1.6, high=1.6)
    unbalance_N_m: float = quantity("N*m", "weight times arm about the axis; only for a single rotary axis", 0.0, low=0, high=1e6)


def _along_slope(tilt_rad: float) -> float:
    return STANDARD_GRAVITY * math.sin(tilt_rad)


EFFECT = Effect(
    entry=Gravity,
    order=80,
    writes=(
        Write("tilt", C.GRAVITY, convert=_along_slope),
        Write("unbalance", J.UNBALANCE),
    ),
    neutral={"tilt": 0.0},
    search=Search(Equation.FORCE, (both("tilt", lambda s: 0.01, 50),)),
    variable="position",
    fingerprint="A pressure difference is needed to hold still, and it depends on the position, not on the velocity.",
    look_alikes={
        "valve_null_bias": "hold still at three positions: a bias drifts without a pressure difference",
        "cross_leakage": "leakage drifts in proportion to the pressure difference",
        "asymmetric_friction": "friction vanishes at rest",
    },
    cases=(Case("rotary", {"tilt": 0.02}, "prismatic.pressure_a"),),
)
