"""Viscous friction: F = B v, of which the share s follows the oil's viscosity, B (1 − s + s ν(T)/ν(40 °C))."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import DAMPING, JointEntry, quantity_by_place
from config.schema.section import quantity
from sim_backend.memory.layout import J


class ViscousFriction(JointEntry):
    effect: Literal["viscous_friction"]
    coefficient: float = quantity_by_place(DAMPING, "friction per speed at 40 degC", low=0, high=1e7)
    oil_share: float = quantity("", "share of it that follows the oil's viscosity", 0.0, low=0, high=1)


EFFECT = Effect(
    entry=ViscousFriction,
    order=30,
    writes=(
        Write("coefficient", J.VISCOUS),
        Write("oil_share", J.VISCOUS_OIL_SHARE),
    ),
    neutral={"coefficient": 0.0},
    search=Search(Equation.FORCE, (up("coefficient", lambda s: 0.03 * s.force / s.velocity, 100),), at_held_rod=True),
    fingerprint="The force residual grows in proportion to the velocity.",
    look_alikes={
        "coulomb_friction": "three or more speed levels",
        "cross_leakage": (
            "leakage acts in the flow balance, friction in the force balance; cold and warm oil change them in opposite directions"
        ),
        "inertia_error": "the same move at two accelerations: only inertia scales with the acceleration",
    },
    cases=(Case("prismatic", {"coefficient": 4000, "oil_share": 0.5}, "prismatic.position"),),
)
