"""reading = factor · value."""

from __future__ import annotations

from config.effects_link_sensor import SensorScale
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import S

EFFECT = Effect(
    entry=SensorScale,
    writes=(Write("factor", S.SCALE),),
    neutral={"factor": 1.0},
    fingerprint="One signal is too large or too small in proportion.",
    look_alikes={
        "valve_flow_asymmetry": "the same in both directions",
        "sensor_offset": "an offset is the same at all values",
    },
)
