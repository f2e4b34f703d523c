"""The evidence that every suspect would add, from sensitivities alone: a Schur complement, no fit.

About a fitted set with precision H and slope g of all its numbers, the columns s of a missing effect (what its parameters change in the
readings, white) meet H through c = J s. With Λ their prior precision

    M = Λ + sᵀs − cᵀH⁻¹c      b = sᵀr − cᵀH⁻¹g      ln Z grows by ½ bᵀM⁻¹b + ½ ln|Λ| − ½ ln|M|

For a number of the rig file that may have changed the column is in J already: what ln Z has of it with its own prior goes, what it has
with the wide one comes, along that column or along a secant to another value.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from config.schema.effect_library import EFFECTS
from gap.data.measured import Array
from gap.evidence.noise.unknowns import in_noise
from gap.evidence.score.changed import Changed
from gap.evidence.score.coordinates import phi_of, stretch
from gap.evidence.score.hypothesis import Hypothesis, Seen, Suspect
from gap.evidence.score.laplace import added
from gap.evidence.score.prior import prior_of
from gap.evidence.secants import Secant
from gap.fitting.model import Model
from gap.fitting.simulate import on_logs
from gap.suspects.candidates import Candidate
from gap.suspects.points import placed, points

_COLUMN_ERROR = 0.03  # of a column, relative: its difference over a size of its own, those of the constants over theirs


@dataclass(frozen=True, slots=True)
class LinearSignature:
    """What a missing effect changes, as straight lines from none of it: `columns` d readings / dφ of its parameters, one Jacobian a log (0
    for those that do nothing alone). `values`: of its parameters where the lines were taken."""

    suspect: Candidate
    values: tuple[float, ...]
    columns: tuple[Array, ...]


@dataclass(frozen=True, slots=True)
class Promise:
    """What a suspect promises: ln Z of the set with it as far as straight lines tell, and the lines."""

    suspect: Suspect
    log_z: float
    signature: LinearSignature | Secant | None = None

    @property
    def has_size(self) -> bool:
        """Whether it is an effect that has a size."""
        return isinstance(self.signature, LinearSignature) and bool(self.signature.suspect.free)


@dataclass(frozen=True, slots=True)
class Freed:
    """What of an effect's columns the constants do not do: sᵀs and sᵀr of its parameters `numbers` that change anything alone; precision
    and ends of their priors."""

    numbers: tuple[int, ...]
    inner: Array
    mixed: Array
    weights: Array
    low: Array
    high: Array


def signatures_of(seen: Seen, base: Hypothesis, suspects: Sequence[Candidate]) -> list[LinearSignature]:
    """A few simulations for every suspect, about the model of `base`: every parameter alone, and one of several at every start."""
    tried = [(suspect, model) for suspect in suspects for model in points(suspect, base.model)]
    vectors = [model.vector() for _, model in tried]
    moved = on_logs(seen.experiments, vectors)
    changes = [
        tuple(in_noise(e, m[k] - r) for e, m, r in zip(seen.experiments, moved, base.at.readings, strict=True)) for k in range(len(tried))
    ]
    found: list[LinearSignature] = []
    for suspect in suspects:
        own = [(model, change) for (other, model), change in zip(tried, changes, strict=True) if other is suspect]
        found += _of_suspect(suspect, own)
    return found


def _of_suspect(suspect: Candidate, tried: Sequence[tuple[Model, tuple[Array, ...]]]) -> list[LinearSignature]:
    """Of tries that move one parameter each a matrix of them all; of an effect with one parameter that can be none, one of every try."""
    sizes = [k for k, free in enumerate(suspect.free) if free.key in EFFECTS[suspect.effect].neutral]
    alone: dict[int, tuple[Model, tuple[Array, ...]]] = {}
    found = []
    if not suspect.free:  # the sign of a sensor: there or not
        return [LinearSignature(suspect, (), tuple(part[None] for part in tried[0][1]))]
    for model, change in tried:
        values = model.theta[model.of_effect(model.added[-1])]
        moved = [k for k in sizes if values[k] != suspect.free[k].start]
        if len(sizes) < 2:
            found.append(_signature(suspect, values, dict.fromkeys(moved, change)))
        elif len(moved) == 1:
            alone[moved[0]] = (model, change)
    if len(sizes) > 1 and alone:
        values = np.array([free.start for free in suspect.free])
        for k, (model, _) in alone.items():
            values[k] = model.theta[model.of_effect(model.added[-1])][k]
        found.append(_signature(suspect, values, {k: change for k, (_, change) in alone.items()}))
    return [s for s in found if any(np.any(part) for part in s.columns)]


def _signature(suspect: Candidate, values: Array, changes: dict[int, tuple[Array, ...]]) -> LinearSignature:
    logs = len(next(iter(changes.values()))) if changes else 0
    columns = []
    for log in range(logs):
        shape = next(iter(changes.values()))[log].shape
        own = np.zeros((len(suspect.free), *shape))
        for k, change in changes.items():
            own[k] = change[log] * suspect.free[k].scale / (values[k] - suspect.free[k].start)
        columns.append(own)
    return LinearSignature(suspect, tuple(float(v) for v in values), tuple(columns))


class Screen:
    """Suspects beside one fitted set."""

    def __init__(self, seen: Seen, base: Hypothesis, signatures: Sequence[LinearSignature], secants: Sequence[Secant] = ()) -> None:
        at, left = base.at, seen.left(base.at.readings)
        columns = [(*(s.columns[n] for s in signatures), *(s.columns[n][None] for s in secants)) for n in range(len(left))]
        rows = [(r[None], j, *own) for r, j, own in zip(left, at.jacobian, columns, strict=True)]
        inner = seen.weighed(rows, at.discrepancy).inner
        own = slice(1, 1 + len(base.model.free))
        prior, phi = prior_of(base.model), phi_of(base.model)
        self._base, self._inner, self._own = base, inner, own
        self._precision, self._phi = prior.precision, phi
        self._inverse = np.linalg.inv(inner[own, own] + np.diag(prior.precision))
        self._slope = inner[own, 0] - prior.precision * phi
        ends = np.cumsum([own.stop, *(len(s.columns[0]) for s in signatures)])
        self._rows = {id(s): np.arange(a, b) for s, a, b in zip(signatures, ends[:-1], ends[1:], strict=True)}
        self._rows |= {id(s): np.array([ends[-1] + k]) for k, s in enumerate(secants)}

    def missing(self, signature: LinearSignature) -> Promise:
        """An effect that the model does not have; one of the signatures given."""
        base, suspect = self._base, signature.suspect
        rows = self._rows[id(signature)]
        if not suspect.free:
            inner, mixed = self._freed(rows)
            return Promise(suspect, base.log_z + float(mixed[0] - 0.5 * inner[0, 0]), signature)
        own = self.freed(signature)
        return Promise(suspect, base.log_z + added(own.inner, own.mixed, own.low, own.high, own.weights), signature)

    def freed(self, signature: LinearSignature) -> Freed:
        """Of an effect that has numbers; one of the signatures given."""
        base, suspect, rows = self._base, signature.suspect, self._rows[id(signature)]
        prior, number = prior_of(base.model.with_effect(suspect.entry, suspect.free)), len(base.model.free)
        use = [k for k in range(len(suspect.free)) if any(np.any(c[k]) for c in signature.columns)]
        inner, mixed = self._freed(rows[use])
        weights, low, high = (part[number:][use] for part in (prior.precision, prior.low, prior.high))
        return Freed(tuple(use), inner, mixed, weights, low, high)

    def changed(self, suspect: Changed, secant: Secant | None = None) -> Promise:
        """A number of the model with a wider prior, along its own column or a secant; one of those given."""
        own = self._base.model
        wide, k = suspect.with_wide_prior(own), suspect.number_in(own)
        row, ratio = (self._rows[id(secant)][0], 1.0) if secant else (1 + k, float(stretch(wide)[k] / stretch(own)[k]))
        gain = self._of_number(k, row, ratio, wide) - self._of_number(k, 1 + k, 1.0, own)
        return Promise(suspect, self._base.log_z + gain, secant)

    def _of_number(self, k: int, row: int, ratio: float, model: Model) -> float:
        """What the number k adds to ln Z beside all others with the prior that it has in `model`, along one row of sensitivities times
        `ratio`: the parabola about the number's value moved to the prior's middle, and cut at the prior's ends."""
        prior, phi = prior_of(model), phi_of(model)[k]
        others = np.delete(np.arange(len(self._inverse)), k)
        inverse = self._inverse[np.ix_(others, others)]
        inverse = inverse - np.outer(self._inverse[others, k], self._inverse[k, others]) / self._inverse[k, k]
        cross = self._inner[row, 1 + others]
        inner = ratio**2 * float(self._inner[row, row] - cross @ inverse @ cross)
        mixed = ratio * float(self._inner[row, 0] - cross @ inverse @ self._slope[others])
        one = (np.array([[inner]]), np.array([mixed + inner * phi]), prior.low[[k]], prior.high[[k]], prior.precision[[k]])
        return added(*one) - float(mixed * phi + 0.5 * inner * phi**2)

    def of_changed(self, suspect: Changed) -> tuple[int, float, float]:
        """Which number of the model it is, its posterior variance under the narrow prior, and the precision of the wide one."""
        model = self._base.model
        number = suspect.number_in(model)
        wide = float(prior_of(suspect.with_wide_prior(model)).precision[number])
        return number, float(self._inverse[number, number]), wide

    def _freed(self, rows: Array) -> tuple[Array, Array]:
        """sᵀs and sᵀr less what the constants do of them. With β = H⁻¹c that is |s − Jβ|² + βᵀβ and (s − Jβ)ᵀr + βᵀφ, the priors' precision
        between; of s − Jβ counts what is more than the error of a finite difference, lest that look like knowledge of what only the priors
        tell from a constant."""
        cross, own = self._inner[rows, self._own], self._inner[np.ix_(rows, rows)]
        beta = self._inverse @ cross.T
        believed, pulled = beta.T @ (self._precision[:, None] * beta), beta.T @ (self._precision * self._phi)
        left = own - cross @ beta - believed
        norms = np.maximum(np.diag(left), np.finfo(float).tiny)  # 0 of what changes nothing
        share = np.sqrt(np.maximum(0.0, 1.0 - _COLUMN_ERROR**2 * np.diag(own) / norms))
        seen = self._inner[rows, 0] - beta.T @ self._inner[self._own, 0]
        return np.outer(share, share) * left + believed, share * seen + pulled


def start_of(base: Model, promise: Promise) -> Model:
    """The set's model with the suspect where its signature was taken."""
    if isinstance(promise.suspect, Changed):
        return promise.suspect.with_wide_prior(base)
    assert isinstance(promise.signature, LinearSignature)
    grown = base.with_effect(promise.suspect.entry, promise.suspect.free)
    return placed(grown, promise.signature.values)
