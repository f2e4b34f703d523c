"""Wilson's interval for a proportion, and a logistic power curve."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize
from scipy.stats import norm


def wilson(hits: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of the proportion hits / trials (Wilson 1927); (0, 1) without trials."""
    if trials == 0:
        return 0.0, 1.0
    z = float(norm.isf((1 - confidence) / 2))
    p = hits / trials
    centre = (p + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z / (1 + z * z / trials) * np.sqrt(p * (1 - p) / trials + z * z / (4 * trials * trials))
    return max(0.0, float(centre - half)), min(1.0, float(centre + half))


def half_power(multiples: Sequence[float], hits: Sequence[bool]) -> float | None:
    """Size at which half of the cases are named: logistic in log(size) with a weak prior on its slope; None if that is outside the data."""
    x, y = np.log(np.asarray(multiples)), np.asarray(hits, dtype=float)
    if len(x) < 4 or y.min() == y.max():
        return None

    def loss(theta: np.ndarray) -> float:
        eta = theta[1] * (x - theta[0])
        return float(np.sum(np.logaddexp(0, eta) - y * eta) + 0.5 * ((theta[1] - 2.0) / 2.0) ** 2)

    best = minimize(loss, np.array([float(x.mean()), 2.0]), method="Nelder-Mead")
    inside = x.min() - np.log(3) <= best.x[0] <= x.max() + np.log(3)
    return float(np.exp(best.x[0])) if inside else None
