"""Mass or inertia that moves with the joint beyond the plant's own: M = M₀ + extra."""

from __future__ import annotations

from config.effects_joint import InertiaError
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=InertiaError,
    writes=(Write("extra", J.EXTRA_MASS),),
    neutral={"extra": 0.0},
    fingerprint="The force residual is proportional to the acceleration, at every position.",
    look_alikes={
        "payload_error": "payload inertia grows with the square of the extension",
        "viscous_friction": "the same move at two accelerations",
        "link_flexibility": "a chirp through the mode; free decay after a stop",
    },
)
