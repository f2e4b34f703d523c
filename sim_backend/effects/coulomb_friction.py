"""Coulomb friction: a force of constant size against the motion, F = F_c sgn(v) once the seals slide.

LuGre: g(v) = F_c (1 + k (T - 40)) is the sliding level; before sliding the bristles deflect by F_c / σ₀.
"""

from __future__ import annotations

from config.effects_joint import CoulombFriction
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=CoulombFriction,
    writes=(
        Write("friction", J.COULOMB),
        Write("temperature_slope", J.COULOMB_SLOPE),
    ),
    neutral={"friction": 0.0},
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
)
