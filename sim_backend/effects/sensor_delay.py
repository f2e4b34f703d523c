"""The reading is the value of some time ago."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import SensorEntry
from config.schema.section import quantity
from sim_backend.memory.layout import S


class SensorDelay(SensorEntry):
    effect: Literal["sensor_delay"]
    delay_s: float = quantity("s", "the signal arrives this much later", low=0, high=0.1)


EFFECT = Effect(
    entry=SensorDelay,
    order=270,
    writes=(Write("delay", S.DELAY),),
    neutral={"delay": 0.0},
    search=Search(Equation.SENSOR, (up("delay", lambda s: 0.002, 50, (1.0, 5.0, 25.0)),)),
    fingerprint="One signal is late against all others.",
    look_alikes={
        "transport_delay": "then everything behind the valve is late",
        "valve_lag": "do the pressures share it?",
    },
    cases=(Case("sensor:rotary.position", {"delay": 0.01}, "raw"),),
)
