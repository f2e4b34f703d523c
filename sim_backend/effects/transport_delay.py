"""The valve acts on the command of some time ago, x_c(t) = u(t − delay)."""

from __future__ import annotations

from config.effects_hydraulic import TransportDelay
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=TransportDelay,
    writes=(Write("delay", J.DELAY),),
    neutral={"delay": 0.0},
    fingerprint="Everything behind the valve is late by one time; phase falls in proportion to frequency, gain does not.",
    look_alikes={
        "valve_lag": "a lag also lowers the gain",
        "sensor_delay": "a late sensor is late alone",
        "backlash": "backlash loses a distance, not a time",
    },
)
