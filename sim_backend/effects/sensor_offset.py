"""reading = value + offset."""

from __future__ import annotations

from config.effects_link_sensor import SensorOffset
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import S

EFFECT = Effect(
    entry=SensorOffset,
    writes=(Write("offset", S.OFFSET),),
    neutral={"offset": 0.0},
    fingerprint="One signal is off by a constant.",
    look_alikes={
        "sensor_scale": "at two values",
        "valve_null_bias": "a bias drifts",
    },
)
