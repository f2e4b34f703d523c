"""Coulomb friction: a force of constant size against the motion, F = F_c sgn(v) once the seals slide.

LuGre: g(v) = F_c (1 + k (T - 40)) is the sliding level; before sliding the bristles deflect by F_c / σ₀.
"""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import FORCE, JointEntry, quantity_by_place
from config.schema.section import quantity
from sim_backend.memory.layout import J


class CoulombFriction(JointEntry):
    effect: Literal["coulomb_friction"]
    friction: float = quantity_by_place(FORCE, "friction while sliding, whatever the speed", low=0, high=1e7)
    temperature_slope: float = quantity("1/K", "relative change per kelvin above 40 degC", 0.0, low=-0.02, high=0.02)


EFFECT = Effect(
    entry=CoulombFriction,
    order=10,
    writes=(
        Write("friction", J.COULOMB),
        Write("temperature_slope", J.COULOMB_SLOPE),
    ),
    neutral={"friction": 0.0},
    search=Search(Equation.FORCE, (up("friction", lambda s: 0.03 * s.force, 30, (1.0, 0.2)),), at_held_rod=True),
    fingerprint="The force residual jumps by twice the friction where the velocity changes sign; small commands do not move the joint.",
    look_alikes={
        "valve_deadband": (
            "with chamber pressures: friction shifts the pressure difference with the sign of the velocity, a dead band "
            "does not; without: decelerations with command and velocity opposite"
        ),
        "viscous_friction": "three or more speed levels: Coulomb friction is the same at each",
        "stiction": "slow reversals: stiction adds a peak only within the Stribeck velocity",
        "valve_hysteresis": "the loop is in pressure difference over velocity, not in flow over command",
    },
    cases=(
        Case("rotary", {"friction": 105, "temperature_slope": -0.004}, "rotary.position"),
        Case("prismatic", {"friction": 1500}, "prismatic.position"),
    ),
)
