"""Which numbers of a rig file are followed: what wear and faults change.

These are the sizes of its effects and what else the search by evidence suspects of having changed (`gap.evidence.score.changed`), and the
oil's bulk modulus, which air in the oil lowers. A log's fit begins at the rig file's value with a prior as wide as wear may be; the rig
file's own prior, from the tag in its comment, gives the limits where none are stated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from config.schema.rig import Rig
from gap.evidence.score.changed import Changed, changeable
from gap.fitting.model import Free

WORN = 0.5  # of its stated value: prior standard deviation of a number that wear may have changed
_ALSO = ("bulk_modulus_Pa",)


@dataclass(frozen=True, slots=True)
class Watched:
    """`name`: `rotary.cross_leakage.conductance`, `rotary.rated_flow`, `oil.bulk_modulus`. `free`: with the prior of its tag; `wide`: as it
    is fitted."""

    name: str
    free: Free
    wide: Free


def watched(rig: Rig, free: tuple[Free, ...]) -> list[Watched]:
    """Every such number among the free constants of a rig, in the order of the file."""
    own = {item.key: item for item in free}
    entries = [(_name(c), own[c.free.key], c.free.low, c.free.high) for c in changeable(rig, free)]
    others = [(f.key.removeprefix("plant."), f, f.low, f.high) for f in free if f.path[-1] in _ALSO]
    return [Watched(name, f, _wide(f, low, high)) for name, f, low, high in [*entries, *others]]


def with_wide_priors(free: tuple[Free, ...], numbers: Sequence[Watched]) -> tuple[Free, ...]:
    """The free constants as a log's fit has them."""
    wide = {number.free.key: number.wide for number in numbers}
    return tuple(wide.get(item.key, item) for item in free)


def _name(changed: Changed) -> str:
    last = changed.free.key.rpartition(".")[2]
    return f"{changed.where}.{last}" if last == changed.effect else f"{changed.where}.{changed.effect}.{last}"


def _wide(free: Free, low: float, high: float) -> Free:
    return replace(free, scale=max(free.scale, WORN * abs(free.start)), low=min(low, free.low), high=max(high, free.high))
