"""Stiction: breakaway needs more than sliding, g(v) = F_c + (F_s − F_c) exp(−(v/v_s)²) with F_s − F_c the excess (Stribeck)."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Freedom, Search, Write, up
from config.schema.effect_entry import FORCE, VELOCITY, JointEntry, quantity_by_place
from sim_backend.memory.layout import J


class Stiction(JointEntry):
    effect: Literal["stiction"]
    excess: float = quantity_by_place(FORCE, "breakaway friction beyond the friction while sliding", low=0, high=1e7)
    velocity: float = quantity_by_place(VELOCITY, "speed at which the excess has fallen to 1/e", low=1e-6, high=10)


EFFECT = Effect(
    entry=Stiction,
    order=20,
    writes=(
        Write("excess", J.STICTION),
        Write("velocity", J.STRIBECK),
    ),
    neutral={"excess": 0.0},
    search=Search(
        Equation.FORCE,
        (
            up("excess", lambda s: 0.02 * s.force, 30),
            Freedom("velocity", lambda s: s.slow, lambda s: 0.1 * s.slow, lambda s: 30 * s.slow, (1.0, 4.0)),
        ),
        beside="coulomb_friction",  # breakaway beyond the friction while sliding needs a friction while sliding
        at_held_rod=True,
    ),
    fingerprint="A peak of force at the start of each slow motion, gone within the Stribeck velocity; stick-slip at the lowest speeds.",
    look_alikes={
        "coulomb_friction": "Coulomb friction has no peak at breakaway",
        "sensor_quantization": "plateaus of constant height in position, not in force",
    },
    cases=(Case("rotary", {"excess": 60, "velocity": 0.03}, "rotary.position"),),
)
