"""Hysteresis between command and spool: a play operator of the given half width."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import JointEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class ValveHysteresis(JointEntry):
    effect: Literal["valve_hysteresis"]
    half_width: float = quantity("", "half width of the play between command and spool, share of the full opening", low=0, high=0.2)


EFFECT = Effect(
    entry=ValveHysteresis,
    order=100,
    writes=(Write("half_width", J.HYSTERESIS),),
    neutral={"half_width": 0.0},
    search=Search(Equation.VALVE, (up("half_width", lambda s: 0.005, 30, (0.4, 3.0)),)),
    variable="command_V",
    fingerprint="Flow over command is a loop of constant width, run through the same way at any frequency.",
    look_alikes={
        "coulomb_friction": "the loop is in flow over command, not in pressure difference over velocity",
        "valve_deadband": "memory: the flow at a command depends on where it came from",
        "transport_delay": "a delay's loop gets narrower when slower",
    },
    cases=(Case("prismatic", {"half_width": 0.01}, "prismatic.position"),),
)
