"""Friction that differs between the directions: F_c ± ΔF_c/2 and B ± ΔB/2 for positive and negative velocity."""

from __future__ import annotations

from config.effects_joint import AsymmetricFriction
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=AsymmetricFriction,
    writes=(
        Write("friction_difference", J.COULOMB_DIFFERENCE),
        Write("coefficient_difference", J.VISCOUS_DIFFERENCE),
    ),
    neutral={"friction_difference": 0.0, "coefficient_difference": 0.0},
    fingerprint=(
        "The friction curve has two different branches; equal commands of opposite sign give different speeds and pressure differences."
    ),
    look_alikes={
        "valve_null_bias": "a bias drifts at rest and does not grow with speed",
        "valve_flow_asymmetry": "flow asymmetry changes the speed but not the pressure difference",
        "gravity": "gravity is a constant force, also at rest",
    },
)
