"""Lands of different area: flows for positive opening times (1 + d/2), for negative times (1 − d/2)."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, both
from config.schema.effect_entry import HydraulicEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class ValveFlowAsymmetry(HydraulicEntry):
    effect: Literal["valve_flow_asymmetry"]
    difference: float = quantity("", "flow area for positive minus negative opening, share of their mean", low=-1.5, high=1.5)


EFFECT = Effect(
    entry=ValveFlowAsymmetry,
    order=140,
    writes=(Write("difference", J.FLOW_ASYMMETRY),),
    neutral={"difference": 0.0},
    search=Search(Equation.VALVE, (both("difference", lambda s: 0.03, 40),)),
    variable="command_V",
    fingerprint="Speed per command differs between the directions in the same ratio at all speeds.",
    look_alikes={
        "asymmetric_friction": "friction changes the pressure difference with it",
        "valve_null_bias": "a bias is the same flow at all commands",
        "sensor_scale": "a scale error is the same in both directions",
    },
    cases=(Case("rotary", {"difference": 0.1}, "rotary.position"),),
)
