"""Which effects could explain the gap at all: sensitivity signatures, freed of what constants and initial states can do, before any fit.

Score of an effect: share of the remaining residual in the span of its signatures. Two effects whose signatures point the same way
(|cos| > 0.95) cannot be told apart on these logs. The length of a signature gives the smallest size that would have been seen.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gap.candidates import Candidate
from gap.fit import Costing, Evaluation, Fit, projected
from gap.measured import Array
from gap.model import Model
from gap.windows import simulate

SAME_DIRECTION = 0.95
PARTNER = 0.9
VISIBLE = 4.5  # standard deviations at which an effect counts as seen
KEPT = 8
MOST_KEPT = 12


@dataclass(frozen=True, slots=True)
class Signature:
    """One candidate before any fit."""

    candidate: Candidate
    share: float  # of the residual's energy that its signatures explain
    smallest_visible: float  # of its first parameter
    unit: str
    leading: Array  # the direction in which it explains the residual best; unit length


@dataclass(frozen=True, slots=True)
class Screening:
    """All candidates, best first, and the cosines between their leading directions (in the same order)."""

    signatures: tuple[Signature, ...]
    cosines: Array

    def kept(self) -> list[Candidate]:
        """The candidates worth a fit: the best few and whatever points the same way as one of them."""
        count = min(KEPT, len(self.signatures))
        chosen = list(range(count))
        for k in range(count, len(self.signatures)):
            if len(chosen) < MOST_KEPT and np.any(np.abs(self.cosines[k, :count]) > PARTNER):
                chosen.append(k)
        return [self.signatures[k].candidate for k in chosen]

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


def screen(current: Fit, costs: Costing, found: Sequence[Candidate], tell: Callable[[str], None]) -> Screening:
    """Two or more simulations a candidate."""
    tell(f"screening {len(found)} candidate effects")
    remover = _Remover(current, costs)
    residual = remover.remove(remover.flat([e.left for e in current.evaluations])[None, :])[0]
    signatures = _signatures(current, found)
    scored = []
    for candidate, columns in zip(found, signatures, strict=True):
        rows = remover.remove(np.stack([remover.flat([p[k] for p in columns]) for k in range(columns[0].shape[0])]))
        scored.append(_scored(candidate, rows, residual, costs))
    scored.sort(key=lambda s: -s.share)
    directions = np.stack([s.leading for s in scored]) if scored else np.empty((0, residual.size))
    return Screening(tuple(scored), directions @ directions.T)


def points(candidate: Candidate, model: Model) -> list[Model]:
    """Models with the candidate in it: every starting point, and every parameter that has a neutral value alone at its typical size."""
    grown = model.with_effect(candidate.entry, candidate.free)
    numbers = grown.of_effect(grown.added[-1])
    found = []
    for values in [*candidate.starts, *_alone(candidate)]:
        theta = grown.theta.copy()
        theta[numbers] = np.clip(values, [grown.free[k].low for k in numbers], [grown.free[k].high for k in numbers])
        found.append(grown.with_theta(theta))
    return found


def _alone(candidate: Candidate) -> list[tuple[float, ...]]:
    """One parameter at its typical size, the others at rest; only where there are several to tell apart."""
    if len(candidate.free) < 2 or candidate.effect in ("stiction", "valve_lag", "link_flexibility"):
        return []
    rest = [free.start for free in candidate.free]
    return [
        tuple(value + (free.scale if j == k else 0.0) for j, (free, value) in enumerate(zip(candidate.free, rest, strict=True)))
        for k, free in enumerate(candidate.free)
    ]


def _signatures(current: Fit, found: Sequence[Candidate]) -> list[list[Array]]:
    """For every candidate: per experiment its signatures (points × windows × values+states)."""
    models = [points(candidate, current.model) for candidate in found]
    vectors = [model.vector() for group in models for model in group]
    ends = np.cumsum([len(group) for group in models])[:-1]
    result: list[list[Array]] = [[] for _ in found]
    for evaluation in current.evaluations:
        readings = simulate(evaluation.experiment, vectors)
        changes = np.stack([np.nan_to_num(r - evaluation.readings, posinf=0.0, neginf=0.0) for r in readings])
        for k, part in enumerate(np.split(projected(evaluation, changes), ends)):
            result[k].append(part)
    return result


def _scored(candidate: Candidate, rows: Array, residual: Array, costs: Costing) -> Signature:
    energy = float(residual @ residual) or 1.0
    lengths = np.linalg.norm(rows, axis=1)
    good = rows[lengths > 1e-9]
    first = float(lengths.max(initial=0.0))
    free = candidate.free[0] if candidate.free else None
    size = abs(candidate.starts[0][0] - free.start) if free else 1.0
    visible = VISIBLE * np.sqrt(costs.tau) * (size or (free.scale if free else 1.0)) / first if first > 0 else np.inf
    if not len(good):
        return Signature(candidate, 0.0, np.inf, free.unit if free else "", np.zeros_like(residual))
    basis, _ = np.linalg.qr(good.T)
    along = basis @ (basis.T @ residual)
    length = float(np.linalg.norm(along))
    leading = along / length if length > 0 else good[0] / np.linalg.norm(good[0])
    return Signature(candidate, length**2 / energy, float(visible), free.unit if free else "", leading)


class _Remover:
    """Takes out of a vector what the free constants can do within their priors."""

    def __init__(self, current: Fit, costs: Costing) -> None:
        self._evaluations: tuple[Evaluation, ...] = current.evaluations
        self._caps = [np.full(e.left.shape[1], np.inf) for e in current.evaluations]
        for cap, evaluation in zip(self._caps, current.evaluations, strict=True):
            values = evaluation.experiment.measured[0].size
            cap[:values] = np.tile(costs.threshold, values // costs.threshold.size)
        self._roots = [
            np.sqrt(np.minimum(1.0, cap / np.maximum(np.abs(e.left), 1e-12))) for e, cap in zip(self._evaluations, self._caps, strict=True)
        ]
        temper = max(1.0, current.cost) * costs.tau
        self._columns = np.stack(
            [self.flat([p[k] for p in parts]) for parts in [self._parts(current)] for k in range(len(current.model.free))]
        )
        prior = np.diag([1.0 if free.prior else 1e-9 for free in current.model.free]) * temper
        self._inverse = np.linalg.pinv(self._columns @ self._columns.T + prior)

    def _parts(self, current: Fit) -> list[Array]:
        return [projected(e, columns) for e, columns in zip(current.evaluations, current.jacobian, strict=True)]

    def flat(self, parts: Sequence[Array]) -> Array:
        """One vector of the experiments' residuals, single bad samples weighted down."""
        return np.concatenate([(part * root).ravel() for part, root in zip(parts, self._roots, strict=True)])

    def remove(self, rows: Array) -> Array:
        return np.asarray(rows - (rows @ self._columns.T) @ self._inverse @ self._columns)
