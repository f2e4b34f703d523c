"""What logs could have shown: the smallest size of every suspect that is not named at which its probability would have reached ½.

About a fitted set, with M as in gap.evidence.screening (what the constants leave of sᵀs, and the prior's precision Λ), a machine that had
the suspect in size a would be expected to give b = (M − Λ) a: the gain ½ bᵀM⁻¹b + ½ ln|Λ| − ½ ln|M| is a parabola in a, and the size sought
is where it pays the odds against one suspect more. An effect is seldom proportional to its size (a dead band), so its column is taken again
where it would just show.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from config.schema.effect_library import EFFECTS
from gap.data.measured import Array
from gap.evidence.noise.unknowns import in_noise
from gap.evidence.score.changed import Changed
from gap.evidence.score.coordinates import phi_of, theta_of
from gap.evidence.score.hypothesis import Hypothesis, Seen, Suspect
from gap.evidence.score.laplace import added
from gap.evidence.screening import LinearSignature, Screen, signatures_of
from gap.fitting.model import Model
from gap.fitting.simulate import simulate
from gap.signatures.candidates import Candidate
from gap.signatures.screen import placed

_ROUNDS = 3  # of columns
_CLOSE = 1.3  # ratio of the size found to the one that its column was taken at, up to which it is proportional


@dataclass(frozen=True, slots=True)
class VisibleSize:
    """A suspect and the size from which it would show: of its first parameter, from its neutral or its stated value, SI; infinite where no
    plausible one would."""

    suspect: Suspect
    parameter: str
    unit: str
    size: float


def visible_sizes(seen: Seen, base: Hypothesis, suspects: Sequence[Suspect], needed: float) -> list[VisibleSize]:
    """Beside a fitted set. `needed`: the gain in ln Z at which a suspect is as probable as not."""
    sizes = _of_missing(seen, base, [s for s in suspects if isinstance(s, Candidate)], needed)
    screen = Screen(seen, base, ())
    sizes |= {s.label: changed_by(screen, base.model, s, needed) for s in suspects if isinstance(s, Changed)}
    return [_named(suspect, sizes.get(suspect.label, np.inf)) for suspect in suspects]


def shown_from(screen: Screen, signature: LinearSignature, needed: float) -> float:
    """The size of the effect's first parameter, in its scale, at which ln Z is expected to grow by `needed`; infinite outside its range."""
    own = screen.freed(signature)
    first = _first(signature.suspect)
    if first not in own.numbers:
        return np.inf
    k = own.numbers.index(first)
    reach = max(own.high[k], -own.low[k])
    if len(own.numbers) > 1:
        m, column = own.inner + np.diag(own.weights), own.inner[:, k]
        occam = 0.5 * float(np.sum(np.log(own.weights)) - np.linalg.slogdet(m)[1])
        size = float(np.sqrt(2.0 * max(needed - occam, 0.0) / (column @ np.linalg.solve(m, column))))
        return size if size <= reach else np.inf
    inner, low, high, weight = own.inner[0, 0], own.low[0], own.high[0], own.weights[0]
    side = 1.0 if own.high[k] == reach else -1.0

    def short(size: float) -> float:
        return added(inner, side * size * inner, low, high, weight)[1] - needed

    return float(brentq(short, 0.0, reach)) if short(reach) > 0.0 > short(0.0) else np.inf


def changed_by(screen: Screen, model: Model, suspect: Changed, needed: float) -> float:
    """By how much (SI) a number of the rig file must differ from what is stated. About a true φ the narrow prior's posterior is expected at
    (1 − v) φ, v its variance; the wide prior's ln Z beside it grows as in Screen.changed."""
    number, variance, wide = screen.of_changed(suspect)
    if wide >= 1.0 or variance >= 1.0 - 1e-9:  # the wide prior is no wider, or the logs say nothing of it
        return np.inf
    less = (wide - 1.0) * variance
    square = (2.0 * needed - np.log(wide) + np.log1p(less)) * (1.0 + less) / (1.0 - wide)
    phi = phi_of(model)
    phi[number] = float(np.sqrt(square)) / (1.0 - variance)
    there = float(theta_of(model, phi)[number])
    return abs(there - suspect.free.start) if suspect.free.low <= there <= suspect.free.high else np.inf


def _of_missing(seen: Seen, base: Hypothesis, suspects: Sequence[Candidate], needed: float) -> dict[str, float]:
    """Sizes by label, SI; columns taken again where they would just show."""
    lines = {s.suspect.label: s for s in reversed(signatures_of(seen, base, suspects)) if s.suspect.free}
    sizes: dict[str, float] = {}
    for left in reversed(range(_ROUNDS)):
        screen = Screen(seen, base, list(lines.values()))
        found = {label: shown_from(screen, line, needed) for label, line in lines.items()}
        sizes |= {label: size * lines[label].suspect.free[_first(lines[label].suspect)].scale for label, size in found.items()}
        again = {label: line for label, line in lines.items() if line.suspect.smaller_is_weaker and not _close(line, sizes[label])}
        if not left or not again:
            break
        lines = dict(zip(again, _taken_at(seen, base, list(again.values()), [sizes[label] for label in again]), strict=True))
    return sizes


def _taken_at(seen: Seen, base: Hypothesis, lines: Sequence[LinearSignature], sizes: Sequence[float]) -> list[LinearSignature]:
    """Each with the column of its first parameter taken at a size, or at the end of its range."""
    models = [_at_size(base.model, line, size) for line, size in zip(lines, sizes, strict=True)]
    moved = [simulate(e, [model.vector() for model in models]) for e in seen.experiments]
    found = []
    for k, (line, model) in enumerate(zip(lines, models, strict=True)):
        changes = [in_noise(e, m[k] - r) for e, m, r in zip(seen.experiments, moved, base.at.readings, strict=True)]
        values = tuple(float(v) for v in model.theta[model.of_effect(model.added[-1])])
        found.append(replace(line, values=values, columns=tuple(_with_column(line, values, n, c) for n, c in enumerate(changes))))
    return found


def _with_column(line: LinearSignature, values: Sequence[float], log: int, change: Array) -> Array:
    k, columns = _first(line.suspect), line.columns[log].copy()
    free = line.suspect.free[k]
    columns[k] = change * free.scale / (values[k] - free.start)
    return columns


def _at_size(model: Model, line: LinearSignature, size: float) -> Model:
    """The first parameter this far from its neutral value and the other sizes at theirs."""
    suspect, k = line.suspect, _first(line.suspect)
    free, neutral = suspect.free[k], EFFECTS[suspect.effect].neutral
    values = [f.start if f.key in neutral else value for f, value in zip(suspect.free, line.values, strict=True)]
    reach = max(free.high - free.start, free.start - free.low)
    side = 1.0 if free.high - free.start == reach else -1.0
    values[k] = free.start + side * min(size, reach)
    return placed(model.with_effect(suspect.entry, suspect.free), values)


def _close(line: LinearSignature, size: float) -> bool:
    """Whether a size is where the column was taken; beyond the range the end of it stands for it."""
    free = line.suspect.free[_first(line.suspect)]
    taken = abs(line.values[_first(line.suspect)] - free.start)
    size = min(size, max(free.high - free.start, free.start - free.low))
    return taken == 0.0 or 1.0 / _CLOSE < size / taken < _CLOSE


def _first(suspect: Candidate) -> int:
    """The number of the parameter that is its size; 0 where it has none."""
    neutral = EFFECTS[suspect.effect].neutral
    return next((k for k, free in enumerate(suspect.free) if free.key in neutral), 0)


def _named(suspect: Suspect, size: float) -> VisibleSize:
    if isinstance(suspect, Changed):
        return VisibleSize(suspect, suspect.free.key.rpartition(".")[2], suspect.free.unit, size)
    if not suspect.free:
        return VisibleSize(suspect, "", "", size)
    free = suspect.free[_first(suspect)]
    return VisibleSize(suspect, free.key, free.unit, size)
