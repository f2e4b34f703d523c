"""Hoses and structure give way: 1/β_e = … + compliance, relative to the chamber's volume."""

from __future__ import annotations

from config.effects_hydraulic import HoseCompliance
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=HoseCompliance,
    writes=(Write("compliance", J.HOSE_COMPLIANCE),),
    neutral={"compliance": 0.0},
    fingerprint="The hydraulic resonance is lower than oil alone would make it, at every pressure.",
    look_alikes={
        "entrained_air": "air is strong at low pressure only",
        "inertia_error": "inertia shows in pressure per acceleration, compliance in flow per pressure change",
    },
)
