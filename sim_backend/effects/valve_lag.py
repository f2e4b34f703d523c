"""Second-order spool: ẍ = ω²(x_c − x) − 2ζω ẋ with ω = 1 / time constant; time constant 0 follows at once."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Freedom, Search, Write
from config.schema.effect_entry import JointEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class ValveLag(JointEntry):
    effect: Literal["valve_lag"]
    time_constant_s: float = quantity("s", "1 / (2 pi f) of the spool's second-order dynamics", low=0, high=0.5)
    damping_ratio: float = quantity("", "damping ratio of the spool", 0.8, low=0.1, high=3)


EFFECT = Effect(
    entry=ValveLag,
    order=130,
    writes=(
        Write("time_constant", J.VALVE_TIME),
        Write("damping_ratio", J.VALVE_DAMPING),
    ),
    neutral={"time_constant": 0.0},
    search=Search(
        Equation.VALVE,
        (
            Freedom("time_constant", lambda s: 0.003, lambda s: 0.0005, lambda s: 0.15, (1.0, 4.0)),
            Freedom("damping_ratio", lambda s: 0.2, lambda s: 0.2, lambda s: 2.0, (4.0,)),
        ),
    ),
    variable="command_rate",
    fingerprint="Flow comes late by a time that is the same for all amplitudes, with a phase that bends at the spool's frequency.",
    look_alikes={
        "transport_delay": "a delay's phase grows without end and its gain stays flat",
        "sensor_delay": "do the pressures share the lag? then it is in front of them",
    },
    cases=(Case("prismatic", {"time_constant": 0.004, "damping_ratio": 0.7}, "prismatic.position"),),
)
