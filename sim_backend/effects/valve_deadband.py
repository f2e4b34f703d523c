"""Overlap of the spool: the lands see sgn(x) max(|x| − overlap, 0)."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import JointEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class ValveDeadband(JointEntry):
    effect: Literal["valve_deadband"]
    overlap: float = quantity("", "spool travel either side of the null without flow, share of the full opening", low=0, high=0.9)


EFFECT = Effect(
    entry=ValveDeadband,
    order=90,
    writes=(Write("overlap", J.OVERLAP),),
    neutral={"overlap": 0.0},
    search=Search(Equation.VALVE, (up("overlap", lambda s: 0.01, 70, (0.3, 2.0)),)),
    variable="command_V",
    fingerprint="Nothing flows for small commands of either sign, and all flows are smaller by the same command.",
    look_alikes={
        "coulomb_friction": "the pressure difference does not change sign with the velocity",
        "valve_hysteresis": "a dead band has no memory: slow triangle of command",
        "backlash": "lost command, not lost distance",
    },
    cases=(Case("rotary", {"overlap": 0.01}, "rotary.position"),),
)
