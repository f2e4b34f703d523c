"""Bending of the link in two shapes that scale with its length, with structural damping C_d = (2ζ₁/ω₁)(EI/L³) K̂.

Bending stiffness 0 stands for a rigid link: a free bending shape of no stiffness has no meaning.
"""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Freedom, Search, Write
from config.schema.effect_entry import LinkEntry
from config.schema.section import quantity
from sim_backend.memory.layout import C

# A link whose frequency is off by a tenth is out of step after five periods, a window's length: fits find only the nearest place.
STIFFNESSES = (1.0, 0.6, 1.7, 0.35, 0.45, 0.8, 1.3, 2.3, 3.0, 4.0, 5.6)


class LinkFlexibility(LinkEntry):
    effect: Literal["link_flexibility"]
    bending_stiffness_N_m2: float = quantity("N*m^2", "EI of the link; 0 stands for a rigid link", low=0, high=1e8)
    damping_ratio: float = quantity("", "structural damping ratio of the first mode", 0.005, low=0, high=0.5)


EFFECT = Effect(
    entry=LinkFlexibility,
    order=240,
    writes=(
        Write("bending_stiffness", C.BENDING_STIFFNESS),
        Write("damping_ratio", C.LINK_DAMPING),
    ),
    neutral={"bending_stiffness": 0.0},
    search=Search(
        Equation.LINK,
        (
            Freedom("bending_stiffness", lambda s: s.bending, lambda s: 0.05 * s.bending, lambda s: 20 * s.bending, STIFFNESSES),
            Freedom("damping_ratio", lambda s: 0.005, lambda s: 0.0005, lambda s: 0.1),
        ),
        smaller_is_weaker=False,  # a link bends the more the smaller its stiffness
    ),
    variable="acceleration",
    fingerprint="A lightly damped oscillation after each stop, slower when extended.",
    look_alikes={
        "inertia_error": "a chirp through the mode; free decay after a stop",
        "backlash": "the frequency does not depend on the amplitude",
        "valve_lag": "pressures oscillate too",
    },
    cases=(Case("link", {"bending_stiffness": 3000, "damping_ratio": 0.01}, "tip.deflection"),),
)
