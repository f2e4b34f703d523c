"""How readings change with a model's free numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.fitting.evaluation import Evaluation
from gap.fitting.model import Model
from gap.fitting.simulate import simulate

MOVE = 0.02  # share of its scale by which an effect is moved for a finite difference
PRIOR_MOVE = 0.3  # … and a constant, of its prior's standard deviation


def sensitivities(
    model: Model, experiments: Sequence[Experiment], numbers: Sequence[int], base: Sequence[Array], widths: Array | None = None
) -> list[Array]:
    """d readings / d φ for each experiment, (numbers × windows × samples × channels), φ = (θ − start) / scale; `base`: readings at θ.

    `widths`: by how much of its scale each of `numbers` is moved for it, where that is known better than from its prior."""
    thetas, moves = [], []
    for order, k in enumerate(numbers):
        free, theta = model.free[k], model.theta.copy()
        share = (PRIOR_MOVE if free.prior else MOVE) if widths is None else float(widths[order])
        move = share * free.scale
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


def shares_of_missed(step: Array, metric: Array) -> Array:
    """Broyden's update (Math. of Computation 19, 1965): by how much of what a step has missed each number's sensitivity changes,
    so that all would have predicted it and change least in a metric (numbers × numbers); 0 where that sees no step."""
    along = metric @ step
    energy = float(step @ along)
    return np.asarray(along / energy) if energy > 0.0 else np.zeros(len(step))


def projected(evaluation: Evaluation, columns: Array) -> Array:
    """Columns of a Jacobian in noise units with the initial states taken out: numbers × windows × values+states."""
    experiment = evaluation.experiment
    there = np.isfinite(experiment.measured)
    scaled = np.nan_to_num(np.where(there, columns / experiment.sigma, 0.0)).reshape(len(columns), experiment.windows, -1)
    return evaluation.projection.apply_all(scaled)
