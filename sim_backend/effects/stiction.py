"""Stiction: breakaway needs more than sliding, g(v) = F_c + (F_s − F_c) exp(−(v/v_s)²) with F_s − F_c the excess (Stribeck)."""

from __future__ import annotations

from config.effects_joint import Stiction
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=Stiction,
    writes=(
        Write("excess", J.STICTION),
        Write("velocity", J.STRIBECK),
    ),
    neutral={"excess": 0.0},
    fingerprint="A peak of force at the start of each slow motion, gone within the Stribeck velocity; stick-slip at the lowest speeds.",
    look_alikes={
        "coulomb_friction": "Coulomb friction has no peak at breakaway",
        "sensor_quantization": "plateaus of constant height in position, not in force",
    },
)
