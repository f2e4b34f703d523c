"""Constants that may as well keep the value that the rig file states: a file is read by people, and what the logs do not speak for stays.

With C the covariance of all numbers, putting those of a set S back by d costs ½ dᵀ C_SS⁻¹ d of ln p, if the others follow by C_·S C_SS⁻¹ d.
"""

from __future__ import annotations

import numpy as np

from gap.data.measured import Array
from gap.fitting.model import Model

_WORTH = 0.5  # of ln p: what all constants that are put back may cost together


def as_stated(model: Model, covariance: Array) -> Model:
    """The model with as many constants as stated as cost next to nothing. `covariance` of θ, numbers × numbers."""
    away = model.theta - np.array([free.start for free in model.free])
    back: list[int] = []
    for k in _by_cost(model, away, covariance):
        if _cost(away, covariance, [*back, k]) <= _WORTH:
            back.append(k)
    if not back:
        return model
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation, pulls = covariance / np.outer(scale, scale), away[back] / scale[back]
    followed = model.theta - scale * (correlation[:, back] @ np.linalg.pinv(correlation[np.ix_(back, back)], hermitian=True) @ pulls)
    theta = np.clip(followed, [free.low for free in model.free], [free.high for free in model.free])
    theta[back] = model.theta[back] - away[back]
    return model.with_theta(theta)


def _by_cost(model: Model, away: Array, covariance: Array) -> list[int]:
    """Numbers of the constants, those first that cost least by themselves."""
    constants = [k for k, free in enumerate(model.free) if free.prior and covariance[k, k] > 0.0]
    return sorted(constants, key=lambda k: float(away[k] ** 2 / covariance[k, k]))


def _cost(away: Array, covariance: Array, some: list[int]) -> float:
    """Of ln p, all numbers free but these."""
    scale = np.sqrt(np.diag(covariance)[some])
    correlation, pulls = covariance[np.ix_(some, some)] / np.outer(scale, scale), away[some] / scale
    return 0.5 * float(pulls @ np.linalg.pinv(correlation, hermitian=True) @ pulls)
