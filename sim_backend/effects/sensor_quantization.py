"""The reading moves in steps: step · round(value / step), before the transducer's own resolution."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import READING, SensorEntry, quantity_by_place
from sim_backend.memory.layout import S


class SensorQuantization(SensorEntry):
    effect: Literal["sensor_quantization"]
    step: float = quantity_by_place(READING, "the reading moves in steps of this size", low=0, high=1e9)


EFFECT = Effect(
    entry=SensorQuantization,
    order=310,
    writes=(Write("step", S.QUANTUM),),
    neutral={"step": 0.0},
    search=Search(Equation.SENSOR, (up("step", lambda s: 8 * s.noise, 100, (1.0, 5.0)),)),
    variable="reading",
    fingerprint="One signal stands still and jumps by equal steps.",
    look_alikes={
        "stiction": "steps are constant in the signal, not in force",
    },
    cases=(Case("sensor:rotary.position", {"step": 0.01}, "raw"),),
)
