"""The spool, or the drive in front of it, reaches only part of the full opening: |x_c| ≤ opening."""

from __future__ import annotations

from config.effects_hydraulic import ValveSaturation
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=ValveSaturation,
    writes=(Write("opening", J.SATURATION),),
    neutral={"opening": 1.0},
    fingerprint="Speed stops growing beyond one fixed command, at any supply pressure.",
    look_alikes={
        "supply_droop": "droop shows in the supply pressure at speed",
        "line_loss": "loss shows in the supply pressure at the valve",
        "valve_deadband": "a dead band acts at the smallest commands",
    },
)
