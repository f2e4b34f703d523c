"""reading = value + offset."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, both
from config.schema.effect_entry import READING, SensorEntry, quantity_by_place
from sim_backend.memory.layout import S


class SensorOffset(SensorEntry):
    effect: Literal["sensor_offset"]
    offset: float = quantity_by_place(READING, "reading at the true value 0", low=-1e9, high=1e9)


EFFECT = Effect(
    entry=SensorOffset,
    order=290,
    writes=(Write("offset", S.OFFSET),),
    neutral={"offset": 0.0},
    search=Search(
        Equation.SENSOR,
        (both("offset", lambda s: max(3 * s.noise, 0.001 * s.span), 300),),
        except_at=("supply_pressure",),  # the set pressure is a constant of the rig
    ),
    variable="reading",
    fingerprint="One signal is off by a constant.",
    look_alikes={
        "sensor_scale": "at two values",
        "valve_null_bias": "a bias drifts",
    },
    cases=(Case("sensor:rotary.position", {"offset": 0.01}, "raw"),),
)
