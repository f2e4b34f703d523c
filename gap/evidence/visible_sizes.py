"""What logs could have shown: the smallest size of every suspect that is not named at which its probability would have reached ½."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from gap.evidence.score.changed import Changed
from gap.evidence.score.hypothesis import Hypothesis, Seen, Suspect
from gap.evidence.screening import Screen, signatures_of
from gap.evidence.where_shown import changed_by, first_lines, first_of, sizes_shown, taken_there
from gap.suspects.candidates import Candidate

_ROUNDS = 3  # of columns


@dataclass(frozen=True, slots=True)
class VisibleSize:
    """A suspect and the size from which it would show: of its first parameter, from its neutral or its stated value, SI; infinite where no
    plausible one would. `assumed`: its other parameters and their units, where the search starts; a spring with hardly any play shows by
    the stiffness assumed, and a stiffer one may not."""

    suspect: Suspect
    parameter: str
    unit: str
    size: float
    assumed: Mapping[str, tuple[float, str]] = field(default_factory=dict)


def visible_sizes(seen: Seen, base: Hypothesis, suspects: Sequence[Suspect], needed: float) -> list[VisibleSize]:
    """Beside a fitted set. `needed`: the gain in ln Z at which a suspect is as probable as not."""
    sizes = _of_missing(seen, base, [s for s in suspects if isinstance(s, Candidate)], needed)
    screen = Screen(seen, base, ())
    sizes |= {s.label: changed_by(screen, base.model, s, needed) for s in suspects if isinstance(s, Changed)}
    return [_named(suspect, sizes.get(suspect.label, np.inf)) for suspect in suspects]


def _of_missing(seen: Seen, base: Hypothesis, suspects: Sequence[Candidate], needed: float) -> dict[str, float]:
    """Sizes by label, SI; columns taken again where they would just show."""
    lines, sizes = first_lines(signatures_of(seen, base, suspects)), dict[str, float]()
    for left in reversed(range(_ROUNDS)):
        sizes |= sizes_shown(Screen(seen, base, lines), lines, needed)
        lines = taken_there(seen, base, lines, sizes) if left else []
        if not lines:
            break
    return sizes


def _named(suspect: Suspect, size: float) -> VisibleSize:
    if isinstance(suspect, Changed):
        return VisibleSize(suspect, suspect.free.key.rpartition(".")[2], suspect.free.unit, size)
    if not suspect.free:
        return VisibleSize(suspect, "", "", size)
    free = suspect.free[first_of(suspect)]
    assumed = {other.key: (other.start, other.unit) for other in suspect.free if other is not free}
    return VisibleSize(suspect, free.key, free.unit, size, assumed)
