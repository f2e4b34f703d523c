"""Signatures: how a model's readings differ from the current ones, what the free constants can do within their priors projected out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.data.measured import Array
from gap.fitting.evaluation import Costing, Evaluation, limits
from gap.fitting.fit import Fit
from gap.fitting.model import Model
from gap.fitting.sensitivity import projected
from gap.fitting.simulate import simulate


@dataclass(frozen=True, slots=True)
class Probe:
    """An effect tried at one size of its first parameter: the energy its signature has left, and what the constants do of it."""

    model: Model
    size: float  # distance from the neutral value
    energy: float
    answers: Array  # of every constant, in its scale


class ConstantsProjection:
    """What the free constants can do within their priors, to be projected out of signatures."""

    def __init__(self, current: Fit, costs: Costing) -> None:
        self._roots = [np.sqrt(weights(e, costs)) for e in current.evaluations]
        temper = max(1.0, current.cost) * costs.tau
        self._residual = self.flat([e.left for e in current.evaluations])
        self._strain = temper * current.model.pulls
        self.energy = float(self._residual @ self._residual + self._strain @ current.model.pulls) or 1.0
        self._columns = np.stack([self.flat([part[k] for part in current.columns]) for k in range(len(current.model.free))])
        prior = np.diag([1.0 if free.prior else 1e-9 for free in current.model.free]) * temper
        self._inverse = np.linalg.pinv(self._columns @ self._columns.T + prior)

    def flat(self, parts: Sequence[Array]) -> Array:
        """One vector of the experiments' residuals, single bad samples weighted down."""
        return np.concatenate([(part * root).ravel() for part, root in zip(parts, self._roots, strict=True)])

    def project_out(self, rows: Array) -> Array:
        return np.asarray(rows - self.answers(rows) @ self._columns)

    def answers(self, rows: Array) -> Array:
        """What the constants do of each row, in their scales: rows × constants."""
        return np.asarray((rows @ self._columns.T) @ self._inverse)

    def slopes(self, rows: Array, left: Array) -> Array:
        """How much of each row the residual holds, and how far the constants' answer to it leads them back to their priors."""
        back = (self._inverse @ self._strain) @ self._columns  # one product with it, not one per constant and row
        return np.asarray(left @ self._residual + rows @ back)


def rows(current: Fit, projection: ConstantsProjection, models: Sequence[Model]) -> Array:
    """Signature of every model against the current one: models × values."""
    parts = changes(current, models)
    return np.stack([projection.flat([part[k] for part in parts]) for k in range(len(models))])


def changes(current: Fit, models: Sequence[Model]) -> list[Array]:
    """The same for each experiment: models × windows × values+states, in noise units with the initial states taken out."""
    vectors, parts = [model.vector() for model in models], []
    for evaluation in current.evaluations:
        readings = simulate(evaluation.experiment, vectors)
        parts.append(projected(evaluation, np.stack([np.nan_to_num(r - evaluation.readings, posinf=0.0, neginf=0.0) for r in readings])))
    return parts


def probed(current: Fit, projection: ConstantsProjection, models: Sequence[Model], sizes: Sequence[float]) -> list[Probe]:
    """Models with an effect at these sizes."""
    plain = rows(current, projection, models)
    energies = np.sum(projection.project_out(plain) ** 2, axis=1)
    return [Probe(*one) for one in zip(models, sizes, energies.tolist(), projection.answers(plain), strict=True)]


def weights(evaluation: Evaluation, costs: Costing) -> Array:
    """Weight of every value in a least-squares step: 1, less beyond the limit of its channel."""
    limit = limits(evaluation.experiment, evaluation.left, costs)
    return np.asarray(np.minimum(1.0, limit / np.maximum(np.abs(evaluation.left), 1e-12)))
