"""Hose between accumulator and valve: ΔP = k Q |Q|, the flow lagged by 2 ms."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import SupplyEntry
from config.schema.section import quantity
from sim_backend.memory.layout import C


class LineLoss(SupplyEntry):
    effect: Literal["line_loss"]
    resistance_Pa_s2_per_m6: float = quantity("Pa*s^2/m^6", "pressure lost in the hose to each valve per squared flow", low=0, high=1e15)


EFFECT = Effect(
    entry=LineLoss,
    order=230,
    writes=(Write("resistance", C.LINE_RESISTANCE),),
    neutral={"resistance": 0.0},
    search=Search(Equation.SUPPLY, (up("resistance", lambda s: 0.01 * s.pressure / 4e-7, 100),)),
    fingerprint="The supply pressure at a valve falls with the square of that valve's flow, at once.",
    look_alikes={
        "supply_droop": "droop follows the volume taken, at all valves",
        "valve_saturation": "the supply pressure stays",
    },
    cases=(Case("supply", {"resistance": 2.5e11}, "prismatic.supply_pressure"),),
)
