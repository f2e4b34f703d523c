"""Null shift of the spool: x_c = u/V_fs + bias + slope (T − 40 °C)."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, both
from config.schema.effect_entry import JointEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class ValveNullBias(JointEntry):
    effect: Literal["valve_null_bias"]
    bias: float = quantity("", "spool opening at command 0 and 40 degC, share of the full opening", low=-0.5, high=0.5)
    temperature_slope: float = quantity("1/K", "null shift per kelvin above 40 degC", 0.0, low=-0.01, high=0.01)


EFFECT = Effect(
    entry=ValveNullBias,
    order=110,
    writes=(
        Write("bias", J.NULL_BIAS),
        Write("temperature_slope", J.NULL_DRIFT),
    ),
    neutral={"bias": 0.0, "temperature_slope": 0.0},
    search=Search(Equation.VALVE, (both("bias", lambda s: 0.005, 60),)),
    variable="command_V",
    fingerprint="The joint drifts at command 0, at the same speed at every position and load.",
    look_alikes={
        "gravity": "gravity needs a pressure difference at rest",
        "cross_leakage": "leakage drifts in proportion to the pressure difference",
        "sensor_offset": "an offset does not drift",
    },
    cases=(Case("rotary", {"bias": 0.01, "temperature_slope": 5e-4}, "rotary.position"),),
)
