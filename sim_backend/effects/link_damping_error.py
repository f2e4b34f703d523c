"""Structural damping of the link beyond that of link_flexibility: ζ₁ = ζ₀ + extra."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Freedom, Search, Write
from config.schema.effect_entry import LinkEntry
from config.schema.section import quantity
from sim_backend.memory.layout import C


class LinkDampingError(LinkEntry):
    effect: Literal["link_damping_error"]
    extra: float = quantity("", "structural damping ratio beyond that of link_flexibility", low=-0.2, high=0.5)


EFFECT = Effect(
    entry=LinkDampingError,
    order=260,
    writes=(Write("extra", C.LINK_DAMPING, added=True),),
    neutral={"extra": 0.0},
    search=Search(Equation.LINK, (Freedom("extra", lambda s: 0.005, lambda s: -0.005, lambda s: 0.1),), beside="link_flexibility"),
    fingerprint="The free decay after a stop is faster or slower, at the right frequency.",
    look_alikes={
        "viscous_friction": "a joint held by its servo: only the link's own damping is left",
        "payload_error": "payload changes the frequency",
    },
    cases=(Case("link", {"extra": 0.01}, "tip.deflection"),),
)
