"""The spool, or the drive in front of it, reaches only part of the full opening: |x_c| ≤ opening."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Freedom, Search, Write
from config.schema.effect_entry import JointEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class ValveSaturation(JointEntry):
    effect: Literal["valve_saturation"]
    opening: float = quantity("", "largest opening reached, share of the full opening", low=0.01, high=1)


EFFECT = Effect(
    entry=ValveSaturation,
    order=120,
    writes=(Write("opening", J.SATURATION),),
    neutral={"opening": 1.0},
    search=Search(Equation.VALVE, (Freedom("opening", lambda s: -0.1, lambda s: 0.02, lambda s: 1.0, (2.0, 5.0, 7.0)),)),
    variable="command_V",
    fingerprint="Speed stops growing beyond one fixed command, at any supply pressure.",
    look_alikes={
        "supply_droop": "droop shows in the supply pressure at speed",
        "line_loss": "loss shows in the supply pressure at the valve",
        "valve_deadband": "a dead band acts at the smallest commands",
    },
    cases=(Case("rotary", {"opening": 0.05}, "rotary.position"),),
)
