"""Null shift of the spool: x_c = u/V_fs + bias + slope (T − 40 °C)."""

from __future__ import annotations

from config.effects_hydraulic import ValveNullBias
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=ValveNullBias,
    writes=(
        Write("bias", J.NULL_BIAS),
        Write("temperature_slope", J.NULL_DRIFT),
    ),
    neutral={"bias": 0.0, "temperature_slope": 0.0},
    fingerprint="The joint drifts at command 0, at the same speed at every position and load.",
    look_alikes={
        "gravity": "gravity needs a pressure difference at rest",
        "cross_leakage": "leakage drifts in proportion to the pressure difference",
        "sensor_offset": "an offset does not drift",
    },
)
