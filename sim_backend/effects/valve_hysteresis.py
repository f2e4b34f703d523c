"""Hysteresis between command and spool: a play operator of the given half width."""

from __future__ import annotations

from config.effects_hydraulic import ValveHysteresis
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=ValveHysteresis,
    writes=(Write("half_width", J.HYSTERESIS),),
    neutral={"half_width": 0.0},
    fingerprint="Flow over command is a loop of constant width, run through the same way at any frequency.",
    look_alikes={
        "coulomb_friction": "the loop is in flow over command, not in pressure difference over velocity",
        "valve_deadband": "memory: the flow at a command depends on where it came from",
        "transport_delay": "a delay's loop gets narrower when slower",
    },
)
