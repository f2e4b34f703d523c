"""Weighted least squares where the logs scatter more than their own intervals say.

y_k = x_k β + u_k + e_k with e_k ~ N(0, s_k²) known and u_k ~ N(0, τ²) from log to log (oil, load, maneuver). τ² is the one at which the
weighted squares of what is left are as large as their degrees of freedom, 0 where they are smaller (R. C. Paule and J. Mandel, Journal of
Research of the NBS 87, 1982; with a design: R. DerSimonian and R. Kacker, Contemporary Clinical Trials 28, 2007). Intervals are Student's
with K − p degrees of freedom (G. Knapp and J. Hartung, Statistics in Medicine 22, 2003), never narrower than the logs' own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import t

from gap.data.measured import Array


@dataclass(frozen=True, slots=True)
class Regression:
    """A fitted design (K × p). `between_sd`: τ."""

    design: Array
    values: Array
    sds: Array
    beta: Array
    covariance: Array
    between_sd: float

    @property
    def freedom(self) -> int:
        return int(len(self.values) - self.design.shape[1])

    @property
    def weights(self) -> Array:
        return np.asarray(1.0 / (self.sds**2 + self.between_sd**2))

    @property
    def bic(self) -> float:
        """−2 ln L + p ln K, without a constant."""
        left = self.values - self.design @ self.beta
        return float(self.weights @ left**2 - np.log(self.weights).sum() + self.design.shape[1] * np.log(len(left)))

    def at(self, row: Array) -> tuple[float, float]:
        """The line at one row of a design, and its standard deviation."""
        return float(row @ self.beta), float(np.sqrt(max(float(row @ self.covariance @ row), 0.0)))

    def times_sd(self, confidence: float = 0.95) -> float:
        """Standard deviations to either end of an interval; infinite where nothing is left to tell the scatter."""
        return float(t.ppf(0.5 + confidence / 2, self.freedom)) if self.freedom else np.inf

    def p_of(self, column: int) -> float:
        """Two-sided, of a coefficient that is 0."""
        z = abs(float(self.beta[column])) / max(float(np.sqrt(self.covariance[column, column])), 1e-300)
        return float(2.0 * t.sf(z, self.freedom)) if self.freedom else 1.0


def regression(design: Array, values: Array, sds: Array) -> Regression:
    """The design fitted with the between-log variance it leaves. LinAlgError where its columns cannot be told apart."""
    free: int = len(values) - design.shape[1]

    def excess(between_var: float) -> float:
        return float(_weighted(design, values, sds, between_var)[2]) - free

    high = float(np.var(values)) + float(np.max(sds)) ** 2
    between_var = 0.0
    if free > 0 and excess(0.0) > 0.0:
        while excess(high) > 0.0:
            high *= 4.0
        between_var = float(brentq(excess, 0.0, high, xtol=1e-9 * high))
    beta, covariance, _ = _weighted(design, values, sds, between_var)
    return Regression(design, values, sds, beta, covariance, float(np.sqrt(between_var)))


def _weighted(design: Array, values: Array, sds: Array, between_var: float) -> tuple[Array, Array, float]:
    """Coefficients, their covariance and the weighted squares left."""
    root = 1.0 / np.sqrt(sds**2 + between_var)
    a, y = design * root[:, None], values * root
    covariance: Array = np.linalg.inv(a.T @ a).astype(np.float64)
    beta: Array = covariance @ (a.T @ y)
    return beta, covariance, float(np.sum((y - a @ beta) ** 2))
