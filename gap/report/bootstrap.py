"""How sure a cost is: neighbouring windows are drawn together, because what they leave is correlated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gap.fitting.evaluation import Evaluation

BLOCK = 3  # neighbouring windows drawn together
DRAWS = 400


def cost_interval(evaluations: Sequence[Evaluation], seed: int = 0) -> tuple[float, float]:
    """95 % interval of the mean window cost, by block bootstrap within each log (E. Carlstein, Annals of Statistics 14, 1986)."""
    draw = np.random.default_rng(seed)
    blocks = [e.window_costs[k : k + BLOCK] for e in evaluations for k in range(0, len(e.window_costs), BLOCK)]
    sums, counts = np.array([b.sum() for b in blocks]), np.array([b.size for b in blocks])
    picks = draw.integers(0, len(blocks), (DRAWS, len(blocks)))
    means = sums[picks].sum(axis=1) / counts[picks].sum(axis=1)
    low, high = np.quantile(means, (0.025, 0.975))
    return float(low), float(high)
