"""Seal friction that grows with the load: g(v) = F_c + c |P_A − P_B| + … (seals are pressed on by the pressure difference)."""

from __future__ import annotations

from config.effects_joint import PressureFriction
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=PressureFriction,
    writes=(Write("coefficient", J.PRESSURE_FRICTION),),
    neutral={"coefficient": 0.0},
    fingerprint="The jump of the force residual at velocity reversal is larger when the pressure difference is larger.",
    look_alikes={
        "coulomb_friction": "repeat at two loads or supply pressures: Coulomb friction stays the same",
        "viscous_friction": "same speed at two loads",
    },
)
