"""Payload beyond the plant's own: M_p = M₀ + extra."""

from __future__ import annotations

from config.effects_link_sensor import PayloadError
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import C

EFFECT = Effect(
    entry=PayloadError,
    writes=(Write("extra", C.PAYLOAD, added=True),),
    neutral={"extra": 0.0},
    fingerprint="Forces per acceleration and the link's frequency are off, more so when extended.",
    look_alikes={
        "inertia_error": "at two extensions: only payload grows with the extension",
        "viscous_friction": "the same move at two accelerations",
    },
)
