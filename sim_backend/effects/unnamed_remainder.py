"""What nobody has a name for, as a table: F(v), F(x), F(u) or F(P_A − P_B), a force on the joint in its positive direction; or friction
over position, g(v) = F_c + table(x) + … ≥ 0.

No physics: only what a balance of forces lacked over the range in which it was seen. The search never tries it, and never calls it found.
"""

from __future__ import annotations

from config.unnamed_remainder import INPUTS, UnnamedRemainder
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J


def _chosen(word: str, code: float) -> tuple[Write, Write]:
    """The knots over one variable, and which it is; an empty list writes nothing."""
    return Write(word, J.TABLE_AT_0, convert=tuple), Write(word, J.TABLE_INPUT, convert=lambda knots: (code,) if knots else ())


def _acting(word: str, rubs: float) -> tuple[Write, Write, Write]:
    """The values at the knots, and whether they are friction. A table of nothing but zeros is none."""
    return (
        Write(word, J.TABLE_FORCE_0, convert=tuple),
        Write(word, J.TABLE_KNOTS, convert=lambda values: (float(len(values)),) if any(values) else ()),
        Write(word, J.TABLE_RUBS, convert=lambda values: (rubs,) if values else ()),
    )


EFFECT = Effect(
    entry=UnnamedRemainder,
    writes=(
        *(write for code, word in enumerate(INPUTS, 1) for write in _chosen(word, float(code))),
        *_acting("force", 0.0),
        *_acting("friction", 1.0),
    ),
    neutral={"force": 0.0, "friction": 0.0},
    fingerprint="Whatever the model still lacks in the balance of forces, over the one variable that carries most of it.",
    look_alikes={},
)
