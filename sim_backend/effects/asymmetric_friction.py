"""Friction that differs between the directions: F_c ± ΔF_c/2 and B ± ΔB/2 for positive and negative velocity."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, both
from config.schema.effect_entry import DAMPING, FORCE, JointEntry, quantity_by_place
from sim_backend.memory.layout import J


class AsymmetricFriction(JointEntry):
    effect: Literal["asymmetric_friction"]
    friction_difference: float = quantity_by_place(FORCE, "sliding friction in positive minus negative direction", 0.0, low=-1e7, high=1e7)
    coefficient_difference: float = quantity_by_place(
        DAMPING, "friction per speed in positive minus negative direction", 0.0, low=-1e7, high=1e7
    )


EFFECT = Effect(
    entry=AsymmetricFriction,
    order=40,
    writes=(
        Write("friction_difference", J.COULOMB_DIFFERENCE),
        Write("coefficient_difference", J.VISCOUS_DIFFERENCE),
    ),
    neutral={"friction_difference": 0.0, "coefficient_difference": 0.0},
    search=Search(
        Equation.FORCE,
        (  # without the friction itself, a difference between the directions would be one-sided friction, which no seal has
            both("friction_difference", lambda s: 0.01 * s.force, 30, beside="coulomb_friction"),
            both("coefficient_difference", lambda s: 0.03 * s.force / s.velocity, 30, beside="viscous_friction"),
        ),
        at_held_rod=True,
    ),
    fingerprint=(
        "The friction curve has two different branches; equal commands of opposite sign give different speeds and pressure differences."
    ),
    look_alikes={
        "valve_null_bias": "a bias drifts at rest and does not grow with speed",
        "valve_flow_asymmetry": "flow asymmetry changes the speed but not the pressure difference",
        "gravity": "gravity is a constant force, also at rest",
    },
    cases=(Case("rotary", {"friction_difference": 40, "coefficient_difference": 300}, "rotary.position"),),
)
