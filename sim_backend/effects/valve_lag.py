"""Second-order spool: ẍ = ω²(x_c − x) − 2ζω ẋ with ω = 1 / time constant; time constant 0 follows at once."""

from __future__ import annotations

from config.effects_hydraulic import ValveLag
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=ValveLag,
    writes=(
        Write("time_constant", J.VALVE_TIME),
        Write("damping_ratio", J.VALVE_DAMPING),
    ),
    neutral={"time_constant": 0.0},
    fingerprint="Flow comes late by a time that is the same for all amplitudes, with a phase that bends at the spool's frequency.",
    look_alikes={
        "transport_delay": "a delay's phase grows without end and its gain stays flat",
        "sensor_delay": "do the pressures share the lag? then it is in front of them",
    },
)
