"""What one model costs on one log: residuals in noise units, robust against single bad samples, initial states marginalised.

(G1) of docs/method/gap.md, with the ρ of P. Huber (Annals of Math. Statistics 35, 1964).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.data.measured import Array
from gap.data.noise import correlation_time
from gap.data.windows import Experiment
from gap.fitting.initial_states import Projection, marginalised_readings
from gap.fitting.model import Model
from gap.fitting.simulate import residual, simulate

FLOOR = 1.0  # noise floors: nothing but noise is left
HUBER = 6.0  # residuals beyond this many standard deviations (of noise, or of the first model's residual) count linearly


@dataclass(frozen=True, slots=True)
class Costing:
    """How residuals count: Huber threshold of every channel, fixed by the first model so that costs compare, and the samples that count as
    one, the correlation time."""

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
    channel_costs: Array  # of every channel over the log; NaN where the log has none of it


def first_costs(experiments: Sequence[Experiment], model: Model) -> tuple[Costing, list[Evaluation]]:
    """How residuals count beside this model, the first one, and the model so counted."""
    plain = [evaluate(e, model, None) for e in experiments]
    costs = costing(experiments, [e.left for e in plain])
    return costs, [judged(e.experiment, e.readings, e.projection, costs) for e in plain]


def costing(experiments: Sequence[Experiment], lefts: Sequence[Array]) -> Costing:
    """From the residuals of the first model."""
    channels = len(experiments[0].columns)
    spread = np.ones(channels)
    for k in range(channels):
        seen = np.concatenate([_by_channel(e, left)[:, :, k].ravel() for e, left in zip(experiments, lefts, strict=True)])
        seen = seen[np.isfinite(seen)]
        spread[k] = max(1.0, 1.4826 * float(np.median(np.abs(seen)))) if seen.size else 1.0
    return Costing(HUBER * spread, _correlation(experiments, lefts))


def recounted(costs: Costing, now: Sequence[Evaluation]) -> Costing:
    """The costing with the correlation time of another model's residual; costs stay comparable."""
    return Costing(costs.threshold, _correlation([e.experiment for e in now], [e.left for e in now]))


def _correlation(experiments: Sequence[Experiment], lefts: Sequence[Array]) -> float:
    shaped = [_by_channel(e, left) for e, left in zip(experiments, lefts, strict=True)]
    channels = [values[:, :, k] for values in shaped for k in range(values.shape[2])]
    return float(np.median([correlation_time(values) for values in channels if np.isfinite(values).any()]))


def evaluate(experiment: Experiment, model: Model, costs: Costing | None, projection: Projection | None = None) -> Evaluation:
    """Simulate a model on one log; the initial states are marginalised about this model unless a projection is given."""
    if projection is None:
        return judged(experiment, *marginalised_readings(experiment, model.vector()), costs)
    return judged(experiment, simulate(experiment, [model.vector()])[0], projection, costs)


def judged(experiment: Experiment, readings: Array, projection: Projection, costs: Costing | None) -> Evaluation:
    """The evaluation of readings that are there already."""
    left = projection.apply(residual(experiment, readings))
    weighed = rho(experiment, left, costs)
    values = experiment.measured[0].size
    there = np.isfinite(experiment.measured)
    data = np.where(there, weighed[:, :values].reshape(experiment.measured.shape), 0.0)
    window_costs = (data.sum(axis=(1, 2)) + weighed[:, values:].sum(axis=1)) / values_compared(experiment)
    values_there = there.sum(axis=(0, 1))
    channel_costs = np.where(values_there > 0, data.sum(axis=(0, 1)) / np.maximum(values_there, 1), np.nan)
    return Evaluation(experiment, projection, readings, left, window_costs, channel_costs)


def values_compared(experiment: Experiment) -> Array:
    """In each window; at least 1."""
    return np.asarray(np.maximum(np.isfinite(experiment.measured).sum(axis=(1, 2)), 1))


def mean_cost(evaluations: Sequence[Evaluation]) -> float:
    """J: 1 at the noise floor."""
    return float(np.concatenate([e.window_costs for e in evaluations]).mean())


def mean_channel_costs(evaluations: Sequence[Evaluation]) -> Array:
    """Of every channel, over the logs that have it; 1 where none has."""
    costs = np.array([e.channel_costs for e in evaluations])
    there = np.isfinite(costs)
    return np.asarray(np.where(there.any(axis=0), np.where(there, costs, 0.0).sum(axis=0) / np.maximum(there.sum(axis=0), 1), 1.0))


def channel_rms(evaluations: Sequence[Evaluation], names: Sequence[str]) -> dict[str, float]:
    """Root mean square of what is left in each channel, in its unit."""
    found = {}
    for k, name in enumerate(names):
        parts = []
        for e in evaluations:
            left = e.left[:, : e.experiment.measured[0].size].reshape(e.experiment.measured.shape)[:, :, k]
            parts.append(left[np.isfinite(e.experiment.measured[:, :, k])] * e.experiment.sigma[k])
        pooled = np.concatenate(parts)
        found[name] = float(np.sqrt(np.mean(pooled**2))) if pooled.size else float("nan")
    return found


def rho(experiment: Experiment, left: Array, costs: Costing | None) -> Array:
    """Cost of every value: its square, or its line beyond the limit."""
    if costs is None:
        return left**2
    limit = limits(experiment, left, costs)
    size = np.abs(left)
    return np.where(size <= limit, size**2, limit * (2 * size - limit))


def limits(experiment: Experiment, left: Array, costs: Costing) -> Array:
    """Residual of every value beyond which it counts linearly; infinite for initial states."""
    values = experiment.measured[0].size
    limit = np.full(left.shape[1], np.inf)
    limit[:values] = np.tile(costs.threshold, values // costs.threshold.size)
    return limit[None, :]


def _by_channel(experiment: Experiment, left: Array) -> Array:
    values = experiment.measured[0].size
    shaped = left[:, :values].reshape(experiment.measured.shape)
    return np.where(np.isfinite(experiment.measured), shaped, np.nan)
