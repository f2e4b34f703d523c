"""How well a fit knows its numbers: its posterior, and never less than what its windows' own votes say."""

from __future__ import annotations

import numpy as np

from gap.data.measured import Array
from gap.fitting.evaluation import Costing, Evaluation
from gap.fitting.fit import Fit, covariance

BOOTSTRAPS = 200
_BLOCK = 3  # neighbouring windows drawn together


def confidence(done: Fit, costs: Costing, seed: int = 0) -> Array:
    """95 % half width of every free number: the larger of posterior and block bootstrap over windows (linearised)."""
    posterior = np.sqrt(np.maximum(np.diag(covariance(done, costs)), 0.0))
    return np.asarray(1.96 * np.maximum(posterior, bootstrap_sd(done, costs, seed)))


def bootstrap_sd(done: Fit, costs: Costing, seed: int = 0) -> Array:
    """Spread of the fitted numbers when windows are drawn again with repetition."""
    temper = max(1.0, done.cost) * costs.tau
    scores = np.concatenate([_window_scores(e, j) for e, j in zip(done.evaluations, done.columns, strict=True)], axis=1) / temper
    inverse = covariance(done, costs) / np.outer(done.model.scales, done.model.scales)
    blocks = [scores[:, k : k + _BLOCK].sum(axis=1) for k in range(0, scores.shape[1], _BLOCK)]
    stacked, draw = np.stack(blocks, axis=1), np.random.default_rng(seed)
    picks = draw.integers(0, len(blocks), (BOOTSTRAPS, len(blocks)))
    moves = np.stack([inverse @ stacked[:, pick].sum(axis=1) for pick in picks])
    return np.asarray(moves.std(axis=0) * done.model.scales)


def _window_scores(evaluation: Evaluation, columns: Array) -> Array:
    """Gradient of the fit by window: numbers × windows."""
    return np.asarray(np.einsum("kwn,wn->kw", columns, evaluation.left))
