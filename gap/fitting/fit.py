"""Fits: Gauss-Newton with damping on [residual / noise ; priors], robust against single bad samples, in units of each number's scale.

While the model is wrong the data are trusted less: residuals are weighted by 1/(τ max(1, J)), with τ their correlation time and J the
cost, so that no constant is torn out of its prior by what a missing effect has left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.fitting.bounded_step import bounded
from gap.fitting.evaluation import Costing, Evaluation, evaluate, judged, limits, mean_cost, rho
from gap.fitting.model import Model
from gap.fitting.sensitivity import projected, sensitivities, shares_of_missed
from gap.fitting.simulate import on_logs

_LEAST_DAMPING = 1e-12  # of a number's own precision: two numbers without priors that do the same stand equally
_DAMPINGS = (0.0, 0.1, 3.0)
INVISIBLE = 0.05  # squared length of a constant's signature, one prior standard deviation, below which its sensitivity is not renewed
CARRIES = 0.05  # of the largest share in a step's effect, below which a constant's sensitivity is not renewed either
MOST_RENEWALS = 2  # of the sensitivities in one fit: more are spent on models that are wrong anyhow
HALF = 0.5  # of the promised gain; a step that gives less was made with stale sensitivities
CONVERGED = 1e-3  # relative gain of a step below which a fit ends
MOST_STEPS = 8


@dataclass(frozen=True, slots=True)
class Fit:
    """A fitted model, its evaluations on the fit logs, the sensitivities it was made with, and the objective reached.

    `jacobian`: d readings / dφ per experiment, numbers × windows × samples × channels. `columns`: the same in noise units with the
    initial states taken out, and brought along with the steps taken since.
    """

    model: Model
    evaluations: tuple[Evaluation, ...]
    jacobian: tuple[Array, ...]
    columns: tuple[Array, ...]
    objective: float

    @property
    def cost(self) -> float:
        return mean_cost(self.evaluations)


def fit(start: Model, experiments: Sequence[Experiment], costs: Costing) -> Fit:
    """Least squares over all free numbers. From step to step the sensitivities follow by C. Broyden's update (Math. of Computation 19,
    1965); where a step disappoints, they are computed again. The initial states are marginalised about `start`."""
    begun = unfitted(start, [evaluate(e, start, costs) for e in experiments], costs)
    work = _Descent(begun, costs)
    fresh, disappointed, renewed = True, False, 0
    for _ in range(MOST_STEPS):
        if disappointed and renewed < MOST_RENEWALS:
            work.renew(work.visible())
            fresh, renewed = True, renewed + 1
        gained, kept_promise = work.step()
        if (gained is None and (fresh or renewed == MOST_RENEWALS)) or (gained is not None and gained < CONVERGED):
            break
        fresh, disappointed = False, not kept_promise
    return Fit(work.model, tuple(work.now), tuple(work.raw), tuple(work.columns), work.objective)


class _Descent:
    """The state of one fit between its steps."""

    def __init__(self, begun: Fit, costs: Costing) -> None:
        self.model, self.now, self._costs = begun.model, list(begun.evaluations), costs
        self.raw, self.columns = list(begun.jacobian), list(begun.columns)
        self.taken: Array | None = None  # the last step, in the numbers' scales
        self._weigh()

    def _weigh(self) -> None:
        self.temper = max(1.0, mean_cost(self.now)) * self._costs.tau
        self.objective = _objective(self.model, self.now, self._costs, self.temper)

    def renew(self, numbers: Sequence[int]) -> None:
        """Compute the sensitivities of these numbers again, at the present model."""
        if not numbers:
            return
        fresh = sensitivities(self.model, [e.experiment for e in self.now], numbers, [e.readings for e in self.now])
        for raw, columns, evaluation, new in zip(self.raw, self.columns, self.now, fresh, strict=True):
            raw[list(numbers)] = new
            columns[list(numbers)] = projected(evaluation, new)

    def visible(self) -> list[int]:
        """The effects' parameters, and the constants that these logs can see and that the last step, if any, moved."""
        energy = sum(np.sum(column**2, axis=(1, 2)) for column in self.columns) / self.temper
        carried = energy * (self.taken**2 if self.taken is not None else 0.0)
        seen = (energy > INVISIBLE) & (carried >= CARRIES**2 * carried.max(initial=0.0))
        return [k for k, free in enumerate(self.model.free) if not free.prior or seen[k]]

    def step(self) -> tuple[float | None, bool]:
        """One step: relative gain (None when no step helps), and whether it gave at least half of what it promised."""
        normal, gradient = _normal_equations(self.model, self.now, self.columns, self._costs, self.temper)
        better = _best_step(self.model, self.now, normal, gradient, self._costs, self.temper, self.objective)
        if better is None:
            self.taken = None
            return None, False
        model, now, reached, promised = better
        gain = self.objective - reached
        relative = gain / max(self.objective, 1e-12)
        self.taken = (model.theta - self.model.theta) / self.model.scales
        self._follow(self.taken, now, normal)
        self.model, self.now = model, now
        self._weigh()
        return relative, gain > HALF * promised

    def _follow(self, step: Array, now: Sequence[Evaluation], normal: Array) -> None:
        """The columns that would have predicted this step, and else changed least, as the posterior measures that."""
        shares = shares_of_missed(step, normal)
        for columns, old, new in zip(self.columns, self.now, now, strict=True):
            missed = old.left - new.left - np.tensordot(step, columns, 1)
            columns += shares[:, None, None] * missed


def covariance(done: Fit, costs: Costing) -> Array:
    """Posterior covariance of θ at the fit, with the weights the data had."""
    temper = max(1.0, done.cost) * costs.tau
    normal, _ = _normal_equations(done.model, done.evaluations, done.columns, costs, temper)
    scales = done.model.scales
    return np.asarray(np.linalg.pinv(normal) * np.outer(scales, scales))


def full_step(done: Fit, costs: Costing) -> tuple[Array, Array]:
    """The Gauss-Newton step of all numbers from where the fit stands, and their posterior standard deviations, both in θ."""
    temper = max(1.0, done.cost) * costs.tau
    normal, gradient = _normal_equations(done.model, done.evaluations, done.columns, costs, temper)
    inverse = np.linalg.pinv(normal)
    return np.asarray(inverse @ gradient * done.model.scales), np.asarray(np.sqrt(np.maximum(np.diag(inverse), 0.0)) * done.model.scales)


def _normal_equations(
    model: Model, now: Sequence[Evaluation], columns: Sequence[Array], costs: Costing, temper: float
) -> tuple[Array, Array]:
    prior = np.array([1.0 if free.prior else 0.0 for free in model.free])
    normal, gradient = np.diag(prior), -prior * model.pulls
    for evaluation, column in zip(now, columns, strict=True):
        limit = limits(evaluation.experiment, evaluation.left, costs)
        root = np.sqrt(np.minimum(1.0, limit / np.maximum(np.abs(evaluation.left), 1e-12)) / temper)
        a = (column * root).reshape(len(model.free), -1)
        normal = normal + a @ a.T
        gradient = gradient + a @ (evaluation.left * root).ravel()
    return normal, gradient


def objective(model: Model, now: Sequence[Evaluation], costs: Costing) -> float:
    """What a fit makes small, with the weights that the data have at this model."""
    return _objective(model, now, costs, max(1.0, mean_cost(now)) * costs.tau)


def _objective(model: Model, now: Sequence[Evaluation], costs: Costing, temper: float) -> float:
    data = sum(float(rho(e.experiment, e.left, costs).sum()) for e in now)
    return data / temper + float(np.sum(model.pulls**2))


def _best_step(
    model: Model, now: Sequence[Evaluation], normal: Array, gradient: Array, costs: Costing, temper: float, objective: float
) -> tuple[Model, list[Evaluation], float, float] | None:
    """The first damping whose step lowers the true objective; also the objective reached and how much less was promised."""
    size = np.diag(normal) + 1e-9
    for damping in _DAMPINGS:
        step = _bounded(model, normal + np.diag((damping + _LEAST_DAMPING) * size), gradient)
        trial = model.with_theta(model.theta + step)
        readings = [own[0] for own in on_logs([e.experiment for e in now], [trial.vector()])]
        after = [judged(e.experiment, y, e.projection, costs) for e, y in zip(now, readings, strict=True)]
        reached = _objective(trial, after, costs, temper)
        if np.isfinite(reached) and reached < objective:
            phi = (trial.theta - model.theta) / model.scales
            return trial, after, reached, float(2.0 * gradient @ phi - phi @ normal @ phi)
    return None


def _bounded(model: Model, normal: Array, gradient: Array) -> Array:
    """The step in θ, within the ranges."""
    low, high = (np.array([getattr(free, end) for free in model.free]) - model.theta for end in ("low", "high"))
    return np.clip(bounded(normal, gradient, low / model.scales, high / model.scales) * model.scales, low, high)


def unfitted(model: Model, now: Sequence[Evaluation], costs: Costing, jacobian: Sequence[Array] | None = None) -> Fit:
    """The model as it stands, evaluated as `now`, with its sensitivities (computed where they are not given)."""
    now, experiments = tuple(now), [e.experiment for e in now]
    if jacobian is None:
        jacobian = sensitivities(model, experiments, range(len(model.free)), [e.readings for e in now])
    columns = tuple(projected(e, j) for e, j in zip(now, jacobian, strict=True))
    return Fit(model, now, tuple(jacobian), columns, objective(model, now, costs))
