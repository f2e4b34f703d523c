"""What nobody has a name for: F = table(v), table(x), table(u) or table(P_A − P_B), a force on the joint in its positive direction.

No physics: only what a balance of forces lacked over the range in which it was seen. The search never tries it, and never calls it found.
"""

from __future__ import annotations

from config.unnamed_remainder import INPUTS, UnnamedRemainder
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J


def _chosen(word: str, code: float) -> tuple[Write, Write]:
    """The knots over one variable, and which it is; an empty list writes nothing."""
    return Write(word, J.TABLE_AT_0, convert=tuple), Write(word, J.TABLE_INPUT, convert=lambda knots: (code,) if knots else ())


def _knots_in_use(force: tuple[float, ...]) -> float:
    """A table of nothing but zeros is none."""
    return float(len(force)) if any(force) else 0.0


EFFECT = Effect(
    entry=UnnamedRemainder,
    writes=(
        *(write for code, word in enumerate(INPUTS, 1) for write in _chosen(word, float(code))),
        Write("force", J.TABLE_FORCE_0, convert=tuple),
        Write("force", J.TABLE_KNOTS, convert=_knots_in_use),
    ),
    neutral={"force": 0.0},
    fingerprint="Whatever the model still lacks in the balance of forces, over the one variable that carries most of it.",
    look_alikes={},
)
