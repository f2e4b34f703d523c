"""Structural damping of the link beyond that of link_flexibility: ζ₁ = ζ₀ + extra."""

from __future__ import annotations

from config.effects_link_sensor import LinkDampingError
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import C

EFFECT = Effect(
    entry=LinkDampingError,
    writes=(Write("extra", C.LINK_DAMPING, added=True),),
    neutral={"extra": 0.0},
    fingerprint="The free decay after a stop is faster or slower, at the right frequency.",
    look_alikes={
        "viscous_friction": "a joint held by its servo: only the link's own damping is left",
        "payload_error": "payload changes the frequency",
    },
)
