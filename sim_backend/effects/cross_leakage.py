"""Laminar leakage across the piston, q = C_l ν(40 °C)/ν(T) (P_A − P_B)."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import HydraulicEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class CrossLeakage(HydraulicEntry):
    effect: Literal["cross_leakage"]
    conductance_m3_per_s_Pa: float = quantity("m^3/s/Pa", "laminar leakage between the chambers at 40 degC", low=0, high=1e-8)


EFFECT = Effect(
    entry=CrossLeakage,
    order=160,
    writes=(Write("conductance", J.CROSS_LEAKAGE),),
    neutral={"conductance": 0.0},
    search=Search(Equation.FLOW, (up("conductance", lambda s: 0.02 * s.area * s.velocity / s.pressure, 200, (1.0, 0.1)),)),
    variable="command_V",
    fingerprint="The joint creeps under load, in proportion to the pressure difference, and faster when warm.",
    look_alikes={
        "valve_null_bias": "a bias drifts without a pressure difference",
        "external_leakage": "both chambers lose pressure against the outside",
        "viscous_friction": "leakage acts in the flow balance",
    },
    cases=(Case("rotary", {"conductance": 1e-11}, "rotary.position"),),
)
