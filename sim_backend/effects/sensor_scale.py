"""reading = factor · value."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Freedom, Search, Write
from config.schema.effect_entry import SensorEntry
from config.schema.section import quantity
from sim_backend.memory.layout import S


class SensorScale(SensorEntry):
    effect: Literal["sensor_scale"]
    factor: float = quantity("", "reading per true value", low=0.01, high=100)


EFFECT = Effect(
    entry=SensorScale,
    order=280,
    writes=(Write("factor", S.SCALE),),
    neutral={"factor": 1.0},
    search=Search(Equation.SENSOR, (Freedom("factor", lambda s: 0.01, lambda s: 0.3, lambda s: 3.0, (1.0, -1.0)),)),
    variable="reading",
    fingerprint="One signal is too large or too small in proportion.",
    look_alikes={
        "valve_flow_asymmetry": "the same in both directions",
        "sensor_offset": "an offset is the same at all values",
    },
    cases=(Case("sensor:rotary.position", {"factor": 1.05}, "raw"),),
)
