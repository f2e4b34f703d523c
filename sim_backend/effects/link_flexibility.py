"""Bending of the link in two shapes that scale with its length, with structural damping C_d = (2ζ₁/ω₁)(EI/L³) K̂.

Bending stiffness 0 stands for a rigid link: a free bending shape of no stiffness has no meaning.
"""

from __future__ import annotations

from config.effects_link_sensor import LinkFlexibility
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import C

EFFECT = Effect(
    entry=LinkFlexibility,
    writes=(
        Write("bending_stiffness", C.BENDING_STIFFNESS),
        Write("damping_ratio", C.LINK_DAMPING),
    ),
    neutral={"bending_stiffness": 0.0},
    fingerprint="A lightly damped oscillation after each stop, slower when extended.",
    look_alikes={
        "inertia_error": "a chirp through the mode; free decay after a stop",
        "backlash": "the frequency does not depend on the amplitude",
        "valve_lag": "pressures oscillate too",
    },
)
