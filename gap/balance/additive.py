"""A smooth description of something that is left: y ≈ Σ g(x), one cubic spline an input, the inputs chosen one after the other
(T. Hastie and R. Tibshirani, Generalized Additive Models, 1990).

What an input carries is judged on rows that were not fitted: every second block of neighbouring rows is predicted from the others, so a
spline cannot take the noise's share for its own. Inputs of few levels (a sign) get one mean a level.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from gap.data.measured import Array

LEAST_SHARE = 0.05  # of the variance, for an input to be said to carry something
MOST = 3  # inputs
_PIECES = 8  # of a spline, each with as many rows
_LEVELS = 4  # up to which an input has means instead of a spline
_SHOWN = 9  # points of a curve
_RIDGE = 1e-6  # of a row's weight: pieces without rows stay where they are


@dataclass(frozen=True, slots=True)
class Curve:
    """One input's part: `share` of the variance of what the inputs before it leave, and the curve over the input's range."""

    name: str
    share: float
    at: Array
    value: Array


def additive(y: Array, inputs: Mapping[str, Array], blocks: NDArray[np.int64]) -> list[Curve]:
    """The inputs that carry y, strongest first; empty when none does.

    `y` and every input: one value a row, all finite; `blocks`: the number of each row's block of neighbours.
    """
    left, open_ = y - y.mean(), dict(inputs)
    found: list[Curve] = []
    while open_ and len(found) < MOST:
        bases = {name: _Basis(x) for name, x in open_.items()}
        shares = {name: _share(basis.columns(open_[name]), left, blocks) for name, basis in bases.items()}
        name = max(shares, key=lambda key: shares[key])
        if shares[name] < LEAST_SHARE:
            break
        x, basis = open_.pop(name), bases[name]
        weights = _fitted(basis.columns(x), left)
        found.append(_curve(name, shares[name], x, basis, weights))
        left = left - basis.columns(x) @ weights
    return found


def alone(y: Array, name: str, x: Array, blocks: NDArray[np.int64]) -> Curve:
    """What one input carries of y by itself, the mean included."""
    basis = _Basis(x)
    columns = basis.columns(x)
    return _curve(name, _share(columns, y, blocks), x, basis, _fitted(columns, y))


def _curve(name: str, share: float, x: Array, basis: _Basis, weights: Array) -> Curve:
    levels = np.unique(x)
    at = levels if len(levels) <= _LEVELS else np.quantile(x, np.linspace(0.02, 0.98, _SHOWN))
    return Curve(name, share, at, basis.columns(at) @ weights)


class _Basis:
    """Columns of a spline (or of levels) whose pieces hold equally many of the rows `x`."""

    def __init__(self, x: Array) -> None:
        self._levels = np.unique(x)
        inner = np.unique(np.quantile(x, np.linspace(0, 1, _PIECES + 1)))
        self._few = len(self._levels) <= _LEVELS or len(inner) < 3
        self._low, self._high = float(inner[0]), float(inner[-1])
        self._knots = np.concatenate([[inner[0]] * 3, inner, [inner[-1]] * 3])

    def columns(self, x: Array) -> Array:
        if self._few:
            return np.asarray(x[:, None] == self._levels[None, :], dtype=np.float64)
        inside = np.clip(x, self._low, self._high)
        return np.asarray(BSpline.design_matrix(inside, self._knots, 3).toarray())


def _fitted(columns: Array, y: Array) -> Array:
    normal = columns.T @ columns
    return np.asarray(np.linalg.solve(normal + _RIDGE * max(float(np.trace(normal)), 1.0) * np.eye(len(normal)), columns.T @ y))


def _share(columns: Array, y: Array, blocks: NDArray[np.int64]) -> float:
    """Of the variance of y, predicted for every second block from the others."""
    odd = blocks % 2 == 1
    if not odd.any() or odd.all():
        return 0.0
    rest = y.copy()
    for part in (odd, ~odd):
        rest[part] -= columns[part] @ _fitted(columns[~part], y[~part])
    return 1.0 - float(rest @ rest) / max(float(y @ y), 1e-300)
