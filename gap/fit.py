"""Fits: Gauss-Newton with damping on [residual / noise ; priors], robust against single bad samples, in units of each number's scale.

While the model is wrong the data are trusted less: residuals are weighted by 1/(τ max(1, J)), with τ their correlation time and J the
cost, so that no constant is torn out of its prior by what a missing effect has left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gap.measured import Array
from gap.model import Model
from gap.noise import correlation_time
from gap.windows import Experiment, Projection, marginalised, residual, simulate

HUBER = 6.0  # residuals beyond this many standard deviations (of noise, or of the first model's residual) count linearly
MOVE = 0.02  # share of its scale by which an effect is moved for a finite difference
_PRIOR_MOVE = 0.3
_DAMPINGS = (0.0, 0.03, 0.3, 3.0, 30.0)
INVISIBLE = 0.05  # squared length of a constant's signature, one prior standard deviation, below which its sensitivity is not renewed
ENOUGH = 5e-3  # relative gain of a step below which a fit ends


@dataclass(frozen=True, slots=True)
class Costing:
    """How residuals count, fixed by the first model so that costs compare: Huber threshold of every channel, correlation time."""

    threshold: Array
    tau: float


@dataclass(frozen=True, slots=True)
class Evaluation:
    """One model on one experiment: residual after marginalisation (windows × values+states), readings, and the cost of every window."""

    experiment: Experiment
    projection: Projection
    readings: Array
    left: Array
    window_costs: Array  # mean-square of a window, in noise units; 1 is the noise floor
    channel_costs: Array  # of every channel over the log


def costing(experiments: Sequence[Experiment], lefts: Sequence[Array]) -> Costing:
    """From the residuals of the first model."""
    channels = len(experiments[0].columns)
    spread = np.ones(channels)
    for k in range(channels):
        seen = np.concatenate([_by_channel(e, left)[:, :, k].ravel() for e, left in zip(experiments, lefts, strict=True)])
        seen = seen[np.isfinite(seen)]
        spread[k] = max(1.0, 1.4826 * float(np.median(np.abs(seen)))) if seen.size else 1.0
    taus = [correlation_time(_by_channel(e, left)[:, :, k]) for e, left in zip(experiments, lefts, strict=True) for k in range(channels)]
    return Costing(HUBER * spread, float(np.median(taus)))


def evaluate(experiment: Experiment, model: Model, costs: Costing | None, projection: Projection | None = None) -> Evaluation:
    """Simulate a model on one log; the initial states are marginalised about this model unless a projection is given."""
    p = model.vector()
    readings = simulate(experiment, [p])[0]
    return judged(experiment, readings, projection or marginalised(experiment, p), costs)


def judged(experiment: Experiment, readings: Array, projection: Projection, costs: Costing | None) -> Evaluation:
    left = projection.apply(residual(experiment, readings))
    rho = _rho(experiment, left, costs)
    values = experiment.measured[0].size
    there = np.isfinite(experiment.measured)
    data = np.where(there, rho[:, :values].reshape(experiment.measured.shape), 0.0)
    counts = np.maximum(there.sum(axis=(1, 2)), 1)
    window_costs = (data.sum(axis=(1, 2)) + rho[:, values:].sum(axis=1)) / counts
    channel_costs = data.sum(axis=(0, 1)) / np.maximum(there.sum(axis=(0, 1)), 1)
    return Evaluation(experiment, projection, readings, left, window_costs, channel_costs)


def mean_cost(evaluations: Sequence[Evaluation]) -> float:
    """J: 1 at the noise floor."""
    return float(np.concatenate([e.window_costs for e in evaluations]).mean())


def sensitivities(model: Model, experiments: Sequence[Experiment], numbers: Sequence[int], base: Sequence[Array]) -> list[Array]:
    """d readings / d φ for each experiment, (numbers × windows × samples × channels), φ = (θ − start) / scale; `base`: readings at θ."""
    thetas, moves = [], []
    for k in numbers:
        free, theta = model.free[k], model.theta.copy()
        move = (_PRIOR_MOVE if free.prior else MOVE) * free.scale
        move = -move if theta[k] + move > free.high else move
        theta[k] += move
        thetas.append(model.vector(theta))
        moves.append(move / free.scale)
    found = []
    for experiment, readings in zip(experiments, base, strict=True):
        moved = simulate(experiment, thetas)
        found.append(
            np.stack([(m - readings) / step for m, step in zip(moved, moves, strict=True)]) if moved else np.empty((0, *readings.shape))
        )
    return found


@dataclass(frozen=True, slots=True)
class Fit:
    """A fitted model, its evaluations on the fit logs, the Jacobian it was made with, and the objective reached."""

    model: Model
    evaluations: tuple[Evaluation, ...]
    jacobian: tuple[Array, ...]  # per experiment, numbers × windows × samples × channels
    objective: float

    @property
    def cost(self) -> float:
        return mean_cost(self.evaluations)


def fit(
    model: Model,
    experiments: Sequence[Experiment],
    costs: Costing,
    moving: Sequence[int],
    jacobian: Sequence[Array] | None = None,
    steps: int = 4,
    projections: Sequence[Projection] | None = None,
    enough: float = ENOUGH,
) -> Fit:
    """Least squares over all free numbers. Sensitivities of the numbers `moving` are renewed at every step; those of the others are
    taken from `jacobian` (columns in the order of model.free) where given, else computed once at the start. The initial states are
    marginalised about the model's start unless `projections` are given."""
    base = [simulate(e, [model.vector()])[0] for e in experiments]
    everything = list(range(len(model.free)))
    columns = list(jacobian) if jacobian is not None else sensitivities(model, experiments, everything, base)
    projections = projections or [marginalised(e, model.vector()) for e in experiments]
    now = [judged(e, y, p, costs) for e, y, p in zip(experiments, base, projections, strict=True)]
    temper = max(1.0, mean_cost(now)) * costs.tau
    objective = _objective(model, now, costs, temper)
    for step in range(steps):
        if moving and (jacobian is not None or step > 0):  # the constants' own are given or new at the first step
            renewed = [k for k in moving if not model.free[k].prior] if step == 0 else _visible(model, now, columns, moving, temper)
            fresh = sensitivities(model, experiments, renewed, [e.readings for e in now])
            columns = [_replaced(old, renewed, new) for old, new in zip(columns, fresh, strict=True)]
        normal, gradient = _normal_equations(model, now, columns, costs, temper)
        better = _best_step(model, now, normal, gradient, costs, temper, objective)
        if better is None:
            break
        gained = (objective - better[2]) / max(objective, 1e-12)
        model, now, objective = better
        temper = max(1.0, mean_cost(now)) * costs.tau
        objective = _objective(model, now, costs, temper)
        if gained < enough:
            break
    return Fit(model, tuple(now), tuple(columns), objective)


def covariance(done: Fit, costs: Costing) -> Array:
    """Posterior covariance of θ at the fit, with the weights the data had."""
    temper = max(1.0, done.cost) * costs.tau
    normal, _ = _normal_equations(done.model, done.evaluations, done.jacobian, costs, temper)
    scales = done.model.scales
    return np.asarray(np.linalg.pinv(normal) * np.outer(scales, scales))


def projected(evaluation: Evaluation, columns: Array) -> Array:
    """Columns of a Jacobian in noise units with the initial states taken out: numbers × windows × values+states."""
    experiment = evaluation.experiment
    there = np.isfinite(experiment.measured)
    return np.stack([evaluation.projection.apply(_scaled(experiment, there, column)) for column in columns])


def _scaled(experiment: Experiment, there: NDArray[np.bool_], column: Array) -> Array:
    return np.nan_to_num(np.where(there, column / experiment.sigma, 0.0)).reshape(experiment.windows, -1)


def _visible(model: Model, now: Sequence[Evaluation], columns: Sequence[Array], moving: Sequence[int], temper: float) -> list[int]:
    """Of `moving`, the effects' parameters and the constants that these logs can see at all."""
    energy = sum(np.sum(projected(e, column) ** 2, axis=(1, 2)) for e, column in zip(now, columns, strict=True)) / temper
    return [k for k in moving if not model.free[k].prior or energy[k] > INVISIBLE]


def _replaced(columns: Array, numbers: Sequence[int], fresh: Array) -> Array:
    changed = columns.copy()
    changed[list(numbers)] = fresh
    return changed


def _rho(experiment: Experiment, left: Array, costs: Costing | None) -> Array:
    if costs is None:
        return left**2
    limit = _limits(experiment, left, costs)
    size = np.abs(left)
    return np.where(size <= limit, size**2, limit * (2 * size - limit))


def _limits(experiment: Experiment, left: Array, costs: Costing) -> Array:
    values = experiment.measured[0].size
    limit = np.full(left.shape[1], np.inf)
    limit[:values] = np.tile(costs.threshold, values // costs.threshold.size)
    return limit[None, :]


def _normal_equations(
    model: Model, now: Sequence[Evaluation], columns: Sequence[Array], costs: Costing, temper: float
) -> tuple[Array, Array]:
    prior = np.array([1.0 if free.prior else 0.0 for free in model.free])
    normal, gradient = np.diag(prior), -prior * model.pulls
    for evaluation, column in zip(now, columns, strict=True):
        limit = _limits(evaluation.experiment, evaluation.left, costs)
        root = np.sqrt(np.minimum(1.0, limit / np.maximum(np.abs(evaluation.left), 1e-12)) / temper)
        a = (projected(evaluation, column) * root).reshape(len(model.free), -1)
        normal = normal + a @ a.T
        gradient = gradient + a @ (evaluation.left * root).ravel()
    return normal, gradient


def _objective(model: Model, now: Sequence[Evaluation], costs: Costing, temper: float) -> float:
    data = sum(float(_rho(e.experiment, e.left, costs).sum()) for e in now)
    return data / temper + float(np.sum(model.pulls**2))


def _best_step(
    model: Model, now: Sequence[Evaluation], normal: Array, gradient: Array, costs: Costing, temper: float, objective: float
) -> tuple[Model, list[Evaluation], float] | None:
    """The first damping whose step lowers the true objective."""
    size = np.diag(normal) + 1e-9
    for damping in _DAMPINGS:
        step = _bounded(model, normal + np.diag(damping * size + 1e-9), gradient)
        trial = model.with_theta(model.theta + step)
        readings = [simulate(e.experiment, [trial.vector()])[0] for e in now]
        after = [judged(e.experiment, y, e.projection, costs) for e, y in zip(now, readings, strict=True)]
        reached = _objective(trial, after, costs, temper)
        if np.isfinite(reached) and reached < objective:
            return trial, after, reached
    return None


def _bounded(model: Model, normal: Array, gradient: Array) -> Array:
    """The step in θ; numbers that would leave their range are put on its end and the others solved again."""
    low = np.array([free.low for free in model.free])
    high = np.array([free.high for free in model.free])
    fixed = np.zeros(len(model.free), dtype=bool)
    step = np.zeros(len(model.free))
    for _ in range(4):
        open_ = ~fixed
        right = gradient[open_] - normal[np.ix_(open_, fixed)] @ (step[fixed] / model.scales[fixed])
        step[open_] = np.linalg.solve(normal[np.ix_(open_, open_)], right) * model.scales[open_]
        outside = open_ & ((model.theta + step < low) | (model.theta + step > high))
        if not outside.any():
            break
        step[outside] = np.clip(model.theta + step, low, high)[outside] - model.theta[outside]
        fixed |= outside
    return np.clip(model.theta + step, low, high) - model.theta


def _by_channel(experiment: Experiment, left: Array) -> Array:
    values = experiment.measured[0].size
    shaped = left[:, :values].reshape(experiment.measured.shape)
    return np.where(np.isfinite(experiment.measured), shaped, np.nan)


def unfitted(model: Model, experiments: Sequence[Experiment], costs: Costing) -> Fit:
    """The model as it stands, with its Jacobian."""
    now = tuple(evaluate(e, model, costs) for e in experiments)
    jacobian = sensitivities(model, experiments, range(len(model.free)), [e.readings for e in now])
    return Fit(model, now, tuple(jacobian), _objective(model, now, costs, max(1.0, mean_cost(now)) * costs.tau))
