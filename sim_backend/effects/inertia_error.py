"""Mass or inertia that moves with the joint beyond the plant's own: M = M₀ + extra."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Freedom, Search, Write
from config.schema.effect_entry import MASS, JointEntry, quantity_by_place
from sim_backend.memory.layout import J


class InertiaError(JointEntry):
    effect: Literal["inertia_error"]
    extra: float = quantity_by_place(MASS, "mass or inertia that moves with the joint beyond the plant's own", low=-1e4, high=1e5)


EFFECT = Effect(
    entry=InertiaError,
    order=70,
    writes=(Write("extra", J.EXTRA_MASS),),
    neutral={"extra": 0.0},
    search=Search(
        Equation.FORCE,
        (Freedom("extra", lambda s: 0.05 * s.mass, lambda s: -0.6 * s.mass, lambda s: 3 * s.mass),),
        at_held_rod=True,
    ),
    variable="acceleration",
    fingerprint="The force residual is proportional to the acceleration, at every position.",
    look_alikes={
        "payload_error": "payload inertia grows with the square of the extension",
        "viscous_friction": "the same move at two accelerations",
        "link_flexibility": "a chirp through the mode; free decay after a stop",
    },
    cases=(Case("rotary", {"extra": 3}, "rotary.position"),),
)
