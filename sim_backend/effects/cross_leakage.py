"""Laminar leakage across the piston, q = C_l ν(40 °C)/ν(T) (P_A − P_B)."""

from __future__ import annotations

from config.effects_hydraulic import CrossLeakage
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=CrossLeakage,
    writes=(Write("conductance", J.CROSS_LEAKAGE),),
    neutral={"conductance": 0.0},
    fingerprint="The joint creeps under load, in proportion to the pressure difference, and faster when warm.",
    look_alikes={
        "valve_null_bias": "a bias drifts without a pressure difference",
        "external_leakage": "both chambers lose pressure against the outside",
        "viscous_friction": "leakage acts in the flow balance",
    },
)
