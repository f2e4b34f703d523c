"""Lands of different area: flows for positive opening times (1 + d/2), for negative times (1 − d/2)."""

from __future__ import annotations

from config.effects_hydraulic import ValveFlowAsymmetry
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=ValveFlowAsymmetry,
    writes=(Write("difference", J.FLOW_ASYMMETRY),),
    neutral={"difference": 0.0},
    fingerprint="Speed per command differs between the directions in the same ratio at all speeds.",
    look_alikes={
        "asymmetric_friction": "friction changes the pressure difference with it",
        "valve_null_bias": "a bias is the same flow at all commands",
        "sensor_scale": "a scale error is the same in both directions",
    },
)
