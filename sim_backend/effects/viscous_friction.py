"""Viscous friction: F = B v, of which the share s follows the oil's viscosity, B (1 − s + s ν(T)/ν(40 °C))."""

from __future__ import annotations

from config.effects_joint import ViscousFriction
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=ViscousFriction,
    writes=(
        Write("coefficient", J.VISCOUS),
        Write("oil_share", J.VISCOUS_OIL_SHARE),
    ),
    neutral={"coefficient": 0.0},
    fingerprint="The force residual grows in proportion to the velocity.",
    look_alikes={
        "coulomb_friction": "three or more speed levels",
        "cross_leakage": (
            "leakage acts in the flow balance, friction in the force balance; cold and warm oil change them in opposite directions"
        ),
        "inertia_error": "the same move at two accelerations: only inertia scales with the acceleration",
    },
)
