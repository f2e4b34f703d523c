"""Hoses and structure give way: 1/β_e = … + compliance, relative to the chamber's volume."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import HydraulicEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class HoseCompliance(HydraulicEntry):
    effect: Literal["hose_compliance"]
    compliance_m3_per_m3_Pa: float = quantity("1/Pa", "relative volume change of hoses and structure per pressure", low=0, high=1e-6)


EFFECT = Effect(
    entry=HoseCompliance,
    order=200,
    writes=(Write("compliance", J.HOSE_COMPLIANCE),),
    neutral={"compliance": 0.0},
    search=Search(Equation.FLOW, (up("compliance", lambda s: 3e-10, 100, (1.0, 4.0)),)),
    variable="acceleration",
    fingerprint="The hydraulic resonance is lower than oil alone would make it, at every pressure.",
    look_alikes={
        "entrained_air": "air is strong at low pressure only",
        "inertia_error": "inertia shows in pressure per acceleration, compliance in flow per pressure change",
    },
    cases=(Case("rotary", {"compliance": 2e-09}, "rotary.position"),),
)
