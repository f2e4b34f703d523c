"""Balance equations without differentiating noise: multiply by a smooth bump φ and integrate by parts
(M. Shinbrot, Trans. ASME 79, 1957; D. Messenger and D. Bortz, Multiscale Modeling & Simulation 19, 2021), (G5) of docs/method/gap.md.

∫φ ẏ dt = −∫φ̇ y dt and ∫φ ÿ dt = ∫φ̈ y dt, because φ and its first three derivatives vanish at both ends of its support. Divided by
∫φ dt each integral is a weighted mean (of y, of its rate, of its acceleration), so an imbalance keeps the unit of its equation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from gap.data.measured import Array

LEAST_ROWS = 9  # of a support
_BUMP = Polynomial([1.0, 0.0, -1.0]) ** 4  # (1 − s²)⁴ on −1 … 1


@dataclass(frozen=True, slots=True)
class Bump:
    """Weights over the rows of one support: Σ weights · samples is a mean over the support."""

    value: Array
    rate: Array
    acceleration: Array
    held: Array  # of a command that is held until the next row

    @property
    def rows(self) -> int:
        return len(self.value)


def bump(rows: int, period_s: float) -> Bump:
    """The weights for a support of `rows` samples, scaled to be exact for parabolas. ValueError below LEAST_ROWS."""
    if rows < LEAST_ROWS:
        raise ValueError(f"a support of {rows} rows cannot resolve the bump; at least {LEAST_ROWS}")
    s = np.linspace(-1.0, 1.0, rows)
    half_s = 0.5 * (rows - 1) * period_s
    whole = _BUMP.integ()
    area = (whole(1.0) - whole(-1.0)) * half_s
    t, value = half_s * s, _BUMP(s) / _BUMP(s).sum()
    rate, acceleration = -_BUMP.deriv(1)(s), _BUMP.deriv(2)(s)
    acceleration = acceleration - acceleration.sum() * value
    steps = np.append(np.diff(whole(s)), 0.0) * half_s / area
    return Bump(value, rate / (rate @ t), 2.0 * acceleration / (acceleration @ t**2), steps)


def supports(values: Array, starts: NDArray[np.int64], rows: int) -> Array:
    """The samples of every support: supports × rows."""
    return np.asarray(values[starts[:, None] + np.arange(rows)[None, :]])


class Sum:
    """One balance at many supports: the imbalance, what sensor noise makes of it, and the size of its largest term."""

    def __init__(self, count: int) -> None:
        self.total: Array = np.zeros(count)
        self.variance: Array = np.zeros(count)
        self.largest: Array = np.zeros(count)

    def add(self, factor: Array | float, weights: Array, samples: Array, noise: float = 0.0) -> None:
        """Add factor × (weighted mean of samples); `factor` a number or one a support, `noise` the standard deviation of a sample."""
        term = factor * (samples @ weights)
        self.total = self.total + term
        self.variance = self.variance + (factor * noise) ** 2 * float(weights @ weights)
        self.largest = np.maximum(self.largest, np.abs(term))
