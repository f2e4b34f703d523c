"""Undissolved air: x_g = α₀ (P₀/P)^(1/n), n = 1.2; 1/β_e = (1 − x_g)/β_l + x_g/(nP) + hoses, P absolute."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import HydraulicEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class EntrainedAir(HydraulicEntry):
    effect: Literal["entrained_air"]
    fraction: float = quantity("", "volume of undissolved air at atmospheric pressure over volume of oil", low=0, high=0.2)


EFFECT = Effect(
    entry=EntrainedAir,
    order=190,
    writes=(Write("fraction", J.AIR_FRACTION),),
    neutral={"fraction": 0.0},
    search=Search(Equation.FLOW, (up("fraction", lambda s: 0.005, 20, (1.0, 0.2)),)),
    variable="acceleration",
    fingerprint="Pressure builds up slowly from low pressures and fast from high ones.",
    look_alikes={
        "hose_compliance": "hoses are as soft at high pressure",
        "bulk_modulus_temperature": "repeat at two supply pressures",
    },
    cases=(Case("prismatic", {"fraction": 0.02}, "prismatic.position"),),
)
