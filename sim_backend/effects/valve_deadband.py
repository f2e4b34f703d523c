"""Overlap of the spool: the lands see sgn(x) max(|x| − overlap, 0)."""

from __future__ import annotations

from config.effects_hydraulic import ValveDeadband
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=ValveDeadband,
    writes=(Write("overlap", J.OVERLAP),),
    neutral={"overlap": 0.0},
    fingerprint="Nothing flows for small commands of either sign, and all flows are smaller by the same command.",
    look_alikes={
        "coulomb_friction": "the pressure difference does not change sign with the velocity",
        "valve_hysteresis": "a dead band has no memory: slow triangle of command",
        "backlash": "lost command, not lost distance",
    },
)
