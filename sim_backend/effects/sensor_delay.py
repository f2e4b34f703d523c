"""The reading is the value of some time ago."""

from __future__ import annotations

from config.effects_link_sensor import SensorDelay
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import S

EFFECT = Effect(
    entry=SensorDelay,
    writes=(Write("delay", S.DELAY),),
    neutral={"delay": 0.0},
    fingerprint="One signal is late against all others.",
    look_alikes={
        "transport_delay": "then everything behind the valve is late",
        "valve_lag": "do the pressures share it?",
    },
)
