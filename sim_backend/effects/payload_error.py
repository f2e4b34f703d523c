"""Payload beyond the plant's own: M_p = M₀ + extra."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Freedom, Search, Write
from config.schema.effect_entry import LinkEntry
from config.schema.section import quantity
from sim_backend.memory.layout import C


class PayloadError(LinkEntry):
    effect: Literal["payload_error"]
    extra_kg: float = quantity("kg", "payload beyond the plant's own", low=-500, high=1000)


EFFECT = Effect(
    entry=PayloadError,
    order=250,
    writes=(Write("extra", C.PAYLOAD, added=True),),
    neutral={"extra": 0.0},
    search=Search(Equation.LINK, (Freedom("extra", lambda s: 0.05 * s.payload, lambda s: -0.9 * s.payload, lambda s: 5 * s.payload),)),
    variable="acceleration",
    fingerprint="Forces per acceleration and the link's frequency are off, more so when extended.",
    look_alikes={
        "inertia_error": "at two extensions: only payload grows with the extension",
        "viscous_friction": "the same move at two accelerations",
    },
    cases=(Case("link", {"extra": 4}, "tip.deflection"),),
)
