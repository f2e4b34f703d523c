"""The valve acts on the command of some time ago, x_c(t) = u(t − delay)."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import JointEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class TransportDelay(JointEntry):
    effect: Literal["transport_delay"]
    delay_s: float = quantity("s", "the valve sees its command this much later", low=0, high=0.1)


EFFECT = Effect(
    entry=TransportDelay,
    order=150,
    writes=(Write("delay", J.DELAY),),
    neutral={"delay": 0.0},
    search=Search(Equation.VALVE, (up("delay", lambda s: 0.002, 45, (1.0, 5.0, 25.0)),)),
    variable="command_rate",
    fingerprint="Everything behind the valve is late by one time; phase falls in proportion to frequency, gain does not.",
    look_alikes={
        "valve_lag": "a lag also lowers the gain",
        "sensor_delay": "a late sensor is late alone",
        "backlash": "backlash loses a distance, not a time",
    },
    cases=(Case("rotary", {"delay": 0.0042}, "rotary.position"),),
)
