"""Signatures where they would just show: an effect is seldom proportional to its size, so a column taken at a typical size says little of
a small one. A dead band hardly shows below the noise; a spring with hardly any play, or a pump beside a stiff accumulator, shows at once.

About a fitted set, with M as in gap.evidence.screening (what the constants leave of sᵀs, and the prior's precision Λ), a machine that had
the suspect in size a would be expected to give b = (M − Λ) a: the gain ½ bᵀM⁻¹b + ½ ln|Λ| − ½ ln|M| is a parabola in a, and the size sought
is where it pays the odds against one suspect more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from config.schema.effect_library import EFFECTS
from gap.data.measured import Array
from gap.evidence.noise.unknowns import in_noise
from gap.evidence.score.changed import Changed
from gap.evidence.score.coordinates import phi_of, theta_of
from gap.evidence.score.hypothesis import Hypothesis, Seen
from gap.evidence.score.laplace import added
from gap.evidence.screening import LinearSignature, Screen
from gap.evidence.secants import CLOSE
from gap.fitting.model import Model
from gap.fitting.simulate import on_logs
from gap.suspects.candidates import Candidate
from gap.suspects.points import placed


def sizes_shown(screen: Screen, lines: Sequence[LinearSignature], needed: float) -> dict[str, float]:
    """By label, of one signature a suspect, which the screen has: the size of its first parameter from which it would show, SI; infinite
    beyond its range. `needed`: the gain in ln Z at which a suspect is as probable as not."""
    return {s.suspect.label: shown_from(screen, s, needed) * s.suspect.free[first_of(s.suspect)].scale for s in lines}


def taken_there(seen: Seen, base: Hypothesis, lines: Sequence[LinearSignature], sizes: Mapping[str, float]) -> list[LinearSignature]:
    """Signatures taken again where they would just show, of those for which that is another size."""
    again = [s for s in lines if s.suspect.smaller_is_weaker and not _close(s, sizes[s.suspect.label])]
    return _taken_at(seen, base, again, [_side(s) * sizes[s.suspect.label] for s in again]) if again else []


def taken_where_led(seen: Seen, base: Hypothesis, line: LinearSignature, there: Model) -> LinearSignature | None:
    """A signature taken again in the size to which it has led, a model with the suspect last; None where it was taken there."""
    k = first_of(line.suspect)
    led = float(there.theta[there.of_effect(there.added[-1])][k]) - line.suspect.free[k].start
    return None if led == 0.0 or _close(line, abs(led)) else _taken_at(seen, base, [line], [led])[0]


def first_lines(signatures: Sequence[LinearSignature]) -> list[LinearSignature]:
    """Of every suspect that has numbers its first signature."""
    return list({s.suspect.label: s for s in reversed(signatures) if s.suspect.free}.values())


def shown_from(screen: Screen, signature: LinearSignature, needed: float) -> float:
    """The size of the effect's first parameter, in its scale, at which ln Z is expected to grow by `needed`; infinite outside its range."""
    own = screen.freed(signature)
    first = first_of(signature.suspect)
    if first not in own.numbers:
        return np.inf
    k = own.numbers.index(first)
    reach = max(own.high[k], -own.low[k])
    side = 1.0 if own.high[k] == reach else -1.0

    def short(size: float) -> float:
        return added(own.inner, side * size * own.inner[:, k], own.low, own.high, own.weights) - needed

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
    if phi[number] > phi_of(suspect.with_value(model, suspect.free.high))[number]:
        return np.inf
    return abs(float(theta_of(model, phi)[number]) - suspect.free.start)


def _taken_at(seen: Seen, base: Hypothesis, lines: Sequence[LinearSignature], sizes: Sequence[float]) -> list[LinearSignature]:
    """Each with the column of its first parameter taken this far from its start, or at the end of its range."""
    models = [_at_size(base.model, line, size) for line, size in zip(lines, sizes, strict=True)]
    moved = on_logs(seen.experiments, [model.vector() for model in models])
    found = []
    for k, (line, model) in enumerate(zip(lines, models, strict=True)):
        changes = [in_noise(e, m[k] - r) for e, m, r in zip(seen.experiments, moved, base.at.readings, strict=True)]
        values = tuple(float(v) for v in model.theta[model.of_effect(model.added[-1])])
        found.append(replace(line, values=values, columns=tuple(_with_column(line, values, n, c) for n, c in enumerate(changes))))
    return found


def _with_column(line: LinearSignature, values: Sequence[float], log: int, change: Array) -> Array:
    k, columns = first_of(line.suspect), line.columns[log].copy()
    free = line.suspect.free[k]
    columns[k] = change * free.scale / (values[k] - free.start)
    return columns


def _at_size(model: Model, line: LinearSignature, size: float) -> Model:
    """The first parameter this far from its neutral value, at the end of its range at most, and the other sizes at theirs."""
    suspect, k = line.suspect, first_of(line.suspect)
    free, neutral = suspect.free[k], EFFECTS[suspect.effect].neutral
    values = [f.start if f.key in neutral else value for f, value in zip(suspect.free, line.values, strict=True)]
    values[k] = min(max(free.start + size, free.low), free.high)
    return placed(model.with_effect(suspect.entry, suspect.free), values)


def _side(line: LinearSignature) -> float:
    """Of an effect's size, towards which its range is longer."""
    free = line.suspect.free[first_of(line.suspect)]
    return 1.0 if free.high - free.start >= free.start - free.low else -1.0


def _close(line: LinearSignature, size: float) -> bool:
    """Whether a size is where the column was taken; beyond the range the end of it stands for it."""
    free = line.suspect.free[first_of(line.suspect)]
    taken = abs(line.values[first_of(line.suspect)] - free.start)
    size = min(size, max(free.high - free.start, free.start - free.low))
    return taken == 0.0 or 1.0 / CLOSE < size / taken < CLOSE


def first_of(suspect: Candidate) -> int:
    """The number of the parameter that is its size; 0 where it has none."""
    neutral = EFFECTS[suspect.effect].neutral
    return next((k for k, free in enumerate(suspect.free) if free.key in neutral), 0)
