"""Hose between accumulator and valve: ΔP = k Q |Q|, the flow lagged by 2 ms."""

from __future__ import annotations

from config.effects_hydraulic import LineLoss
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import C

EFFECT = Effect(
    entry=LineLoss,
    writes=(Write("resistance", C.LINE_RESISTANCE),),
    neutral={"resistance": 0.0},
    fingerprint="The supply pressure at a valve falls with the square of that valve's flow, at once.",
    look_alikes={
        "supply_droop": "droop follows the volume taken, at all valves",
        "valve_saturation": "the supply pressure stays",
    },
)
