"""reading = sign · value."""

from __future__ import annotations

from config.effects_link_sensor import SensorPolarity
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import S

EFFECT = Effect(
    entry=SensorPolarity,
    writes=(Write("sign", S.POLARITY),),
    neutral={"sign": 1.0},
    fingerprint="One signal moves the wrong way.",
    look_alikes={
        "sensor_scale": "the factor is −1",
    },
)
