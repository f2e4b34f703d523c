"""The reading moves in steps: step · round(value / step), before the transducer's own resolution."""

from __future__ import annotations

from config.effects_link_sensor import SensorQuantization
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import S

EFFECT = Effect(
    entry=SensorQuantization,
    writes=(Write("step", S.QUANTUM),),
    neutral={"step": 0.0},
    fingerprint="One signal stands still and jumps by equal steps.",
    look_alikes={
        "stiction": "steps are constant in the signal, not in force",
    },
)
