"""Undissolved air: x_g = α₀ (P₀/P)^(1/n), n = 1.2; 1/β_e = (1 − x_g)/β_l + x_g/(nP) + hoses, P absolute."""

from __future__ import annotations

from config.effects_hydraulic import EntrainedAir
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=EntrainedAir,
    writes=(Write("fraction", J.AIR_FRACTION),),
    neutral={"fraction": 0.0},
    fingerprint="Pressure builds up slowly from low pressures and fast from high ones.",
    look_alikes={
        "hose_compliance": "hoses are as soft at high pressure",
        "bulk_modulus_temperature": "repeat at two supply pressures",
    },
)
