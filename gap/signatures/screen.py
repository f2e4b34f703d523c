"""Which effects could explain the gap at all, before any fit: their signatures with constants and initial states projected out.

Score of an effect: the share of residual and strain of the constants that the best multiple of one of its signatures takes away, all
constants answering. Two effects whose signatures point the same way (|cos| > 0.95) cannot be told apart on these logs. The length of a
signature gives the smallest size that would have been named.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from config.progress import Progress
from config.schema.effect_library import EFFECTS
from gap.data.measured import Array
from gap.fitting.evaluation import Costing
from gap.fitting.fit import Fit
from gap.fitting.model import Model
from gap.fitting.thinned import TO_SIZE, thinned
from gap.signatures.candidates import Candidate
from gap.signatures.projection import ConstantsProjection, Probe, rows

SAME_DIRECTION = 0.95
PARTNER = 0.9
VISIBLE = 4.5  # standard deviations below which no signature counts as seen, whatever the gates let pass
KEPT = 8
MOST_KEPT = 12


@dataclass(frozen=True, slots=True)
class TriedSize:
    """One size of a candidate, simulated: its model and its signature, flat, nuisances taken out. To second order m times this size
    lowers the fit's objective by 2 m `slope` − m² `curvature`, with the constants where they are best then."""

    model: Model
    row: Array
    slope: float
    curvature: float
    most: float  # largest and smallest multiple of this size within the parameters' ranges
    least: float
    answers: Array  # what the constants do of the signature, in their scales

    @property
    def multiple(self) -> float:
        """The best multiple of this size."""
        return float(np.clip(self.slope / self.curvature, self.least, self.most)) if self.curvature > 0.0 else 0.0

    def lowers(self, multiple: float) -> float:
        """What a multiple of this size takes from the objective."""
        return 2.0 * multiple * self.slope - multiple**2 * self.curvature


@dataclass(frozen=True, slots=True)
class Signature:
    """One candidate before any fit."""

    candidate: Candidate
    share: float  # of the residual's energy that its signatures explain
    smallest_visible: float  # of its first parameter
    unit: str
    leading: Array  # the direction in which it explains the residual best; unit length
    starts: tuple[Model, ...]  # from which to fit it, the most promising first
    probe: Probe | None  # it alone, at the size closest to where it would just be named


@dataclass(frozen=True, slots=True)
class Screening:
    """All candidates, best first, and the cosines between their leading directions (in the same order)."""

    signatures: tuple[Signature, ...]
    cosines: Array

    def kept(self) -> list[Signature]:
        """The candidates worth a fit: the best few and whatever points the same way as one of them."""
        count = min(KEPT, len(self.signatures))
        chosen = list(range(count))
        for k in range(count, len(self.signatures)):
            if len(chosen) < MOST_KEPT and np.any(np.abs(self.cosines[k, :count]) > PARTNER):
                chosen.append(k)
        return [self.signatures[k] for k in chosen]

    def same_direction(self, effect: str, where: str) -> list[Candidate]:
        """Candidates indistinguishable from this one on these logs."""
        names = [(s.candidate.effect, s.candidate.where) for s in self.signatures]
        if (effect, where) not in names:
            return []
        row = np.abs(self.cosines[names.index((effect, where))])
        return [
            s.candidate
            for s, c in zip(self.signatures, row, strict=True)
            if c > SAME_DIRECTION and (s.candidate.effect, s.candidate.where) != (effect, where)
        ]

    def shares_by_equation(self) -> Mapping[tuple[str, str], float]:
        """The largest share any effect of an equation and place explains."""
        best: dict[tuple[str, str], float] = {}
        for s in self.signatures:
            key = (s.candidate.equation, s.candidate.where)
            best[key] = max(best.get(key, 0.0), s.share)
        return best


def screen(current: Fit, costs: Costing, found: Sequence[Candidate], seen_at: float, progress: Progress) -> Screening:
    """Two or more simulations a candidate. `seen_at`: energy of a signature (noise units squared) at which its effect would be named."""
    current, share = thinned(current)
    return _screened(current, costs, found, [points(candidate, current.model) for candidate in found], share * seen_at, progress)


def screen_sizes(
    current: Fit, costs: Costing, found: Sequence[Candidate], seen_at: float, progress: Progress, before: Screening | None
) -> Screening:
    """One simulation a candidate, which its smallest size follows from; starting points are not ranked. `before`: an earlier screening on
    the same logs, from which it is known how large to try each."""
    current, share = thinned(current, TO_SIZE)
    known = {s.candidate.label: s.probe for s in before.signatures if s.probe} if before else {}
    groups = [[_likely(c, current.model, known.get(c.label), share * seen_at)] for c in found]
    return _screened(current, costs, found, groups, share * seen_at, progress)


def _screened(
    current: Fit, costs: Costing, found: Sequence[Candidate], groups: Sequence[list[Model]], seen_at: float, progress: Progress
) -> Screening:
    progress(f"screening {len(found)} candidate effects")
    projection = ConstantsProjection(current, costs)
    plain = rows(current, projection, [model for group in groups for model in group])
    left = projection.project_out(plain)
    slopes, curvatures = projection.slopes(plain, left), np.sum(plain * left, axis=1)
    ends, answers = np.cumsum([len(group) for group in groups])[:-1], projection.answers(plain)
    parts = zip(found, groups, *(np.split(values, ends) for values in (left, slopes, curvatures, answers)), strict=True)
    scored = [_scored(c, [_point(c, *one) for one in zip(*tried, strict=True)], projection.energy, seen_at) for c, *tried in parts]
    scored.sort(key=lambda s: -s.share)
    directions = np.stack([s.leading for s in scored]) if scored else np.empty((0, left.shape[1]))
    return Screening(tuple(scored), directions @ directions.T)


def points(candidate: Candidate, model: Model) -> list[Model]:
    """Models with the candidate in it: every starting point, and every parameter that has a neutral value alone at its typical size."""
    grown = model.with_effect(candidate.entry, candidate.free)
    return [placed(grown, values) for values in [*candidate.starts, *_alone(candidate)]]


def placed(grown: Model, values: Sequence[float]) -> Model:
    """The model with these values of its last effect's parameters, within their ranges."""
    numbers = grown.of_effect(grown.added[-1])
    theta = grown.theta.copy()
    theta[numbers] = np.clip(values, [grown.free[k].low for k in numbers], [grown.free[k].high for k in numbers])
    return grown.with_theta(theta)


def _likely(candidate: Candidate, model: Model, known: Probe | None, seen_at: float) -> Model:
    """The effect alone, about as large as would just be named if it is proportional to its size; else at its typical size."""
    typical = points(candidate, model)[len(candidate.starts) if _alone(candidate) else 0]
    if known is None or not candidate.smaller_is_weaker or candidate.free[0].key not in EFFECTS[candidate.effect].neutral:
        return typical
    values = typical.theta[typical.of_effect(typical.added[-1])].copy()
    side = np.sign(values[0] - candidate.free[0].start) or 1.0
    values[0] = candidate.free[0].start + side * known.size * float(np.sqrt(seen_at / known.energy))
    return placed(typical, [float(v) for v in values])


def _alone(candidate: Candidate) -> list[tuple[float, ...]]:
    """One parameter at its typical size, the others at rest; only where there are several to tell apart."""
    if sum(free.key in EFFECTS[candidate.effect].neutral for free in candidate.free) < 2:
        return []
    rest = [free.start for free in candidate.free]
    return [
        tuple(value + (free.scale if j == k else 0.0) for j, (free, value) in enumerate(zip(candidate.free, rest, strict=True)))
        for k, free in enumerate(candidate.free)
    ]


def _point(candidate: Candidate, model: Model, row: Array, slope: float, curvature: float, answers: Array) -> TriedSize:
    """With the multiples that stay within the ranges: a delay or a dead band of less than nothing explains nothing."""
    values = model.theta[model.of_effect(model.added[-1])]
    ends = []
    for free, value in zip(candidate.free, values, strict=True):
        if free.key in EFFECTS[candidate.effect].neutral and value != free.start:
            ends.append(sorted(((free.low - free.start) / (value - free.start), (free.high - free.start) / (value - free.start))))
    least, most = (max(low for low, _ in ends), min(high for _, high in ends)) if ends else (0.0, 1.0)
    return TriedSize(model, row, float(slope), float(curvature), most, least, answers)


def _scored(candidate: Candidate, tried: Sequence[TriedSize], energy: float, seen_at: float) -> Signature:
    unit = candidate.free[0].unit if candidate.free else ""
    good = [point for point in tried if np.linalg.norm(point.row) > 1e-9]
    starts = _starts(candidate, tried)
    if not good:
        return Signature(candidate, 0.0, np.inf, unit, np.zeros_like(tried[0].row), starts, None)
    best = max(good, key=lambda point: point.lowers(point.multiple))
    leading = best.row / np.linalg.norm(best.row)
    probe = _probe(candidate, tried, seen_at)
    visible = probe.size * float(np.sqrt(seen_at / probe.energy)) if probe else np.inf
    return Signature(candidate, best.lowers(best.multiple) / energy, visible, unit, leading, starts, probe)


def _starts(candidate: Candidate, tried: Sequence[TriedSize]) -> tuple[Model, ...]:
    """The sizes tried and the one at which the best signature, as a straight line, would explain most; by what they leave."""
    ranked = sorted(tried, key=lambda point: -point.lowers(1.0))
    models = [point.model for point in ranked]
    best = max(tried, key=lambda point: point.lowers(point.multiple))
    neutral = [free.key in EFFECTS[candidate.effect].neutral for free in candidate.free]
    if best.curvature <= 0.0 or not any(neutral) or not candidate.smaller_is_weaker:  # whose neutral value is the stiffest link
        return tuple(models)
    there = best.model.theta[best.model.of_effect(best.model.added[-1])]
    values = [f.start + best.multiple * (v - f.start) if n else v for f, v, n in zip(candidate.free, there, neutral, strict=True)]
    line = placed(best.model, values)
    return (line, *models) if best.lowers(best.multiple) > ranked[0].lowers(1.0) else (models[0], line, *models[1:])


def _probe(candidate: Candidate, tried: Sequence[TriedSize], seen_at: float) -> Probe | None:
    """Of the sizes tried with the first parameter alone, the one closest to where the effect would just be named."""
    found = []
    for point in tried if candidate.free else ():
        values = point.model.theta[point.model.of_effect(point.model.added[-1])]
        moved = [float(value - free.start) for value, free in zip(values, candidate.free, strict=True)]
        alone = not any(m for m, free in zip(moved[1:], candidate.free[1:], strict=True) if free.key in EFFECTS[candidate.effect].neutral)
        energy = float(point.row @ point.row)
        if energy > 1e-18 and alone:
            found.append(Probe(point.model, abs(moved[0]) or candidate.free[0].scale, energy, point.answers))
    return min(found, key=lambda probe: abs(np.log(probe.energy / seen_at)), default=None)
