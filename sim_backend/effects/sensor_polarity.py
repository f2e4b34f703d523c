"""reading = sign · value."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write
from config.schema.effect_entry import SensorEntry
from sim_backend.memory.layout import S


class SensorPolarity(SensorEntry):
    effect: Literal["sensor_polarity"]
    sign: Literal[-1, 1]


EFFECT = Effect(
    entry=SensorPolarity,
    order=300,
    writes=(Write("sign", S.POLARITY),),
    neutral={"sign": 1.0},
    search=Search(Equation.SENSOR, (), {"sign": lambda s: -1}),
    variable="reading",
    fingerprint="One signal moves the wrong way.",
    look_alikes={
        "sensor_scale": "the factor is −1",
    },
    cases=(Case("sensor:rotary.position", {"sign": -1}, "raw"),),
)
