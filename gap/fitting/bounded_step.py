"""The step of a fit within ranges: where a quadratic is largest in a box."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import lsq_linear

from gap.data.measured import Array


def bounded(precision: Array, slope: Array, low: Array, high: Array) -> Array:
    """The largest of slopeᵀx − ½ xᵀ precision x with x within (low, high): by bounded least squares (Stark and Parker, Computational
    Statistics 10, 1995) where the free maximum lies outside. To put what leaves on its end and solve for the rest is not enough: the rest
    may then leave at the other end, one number after the other."""
    step = np.linalg.solve(precision, slope)
    if np.all((step >= low) & (step <= high)):
        return np.asarray(step)
    root = np.linalg.cholesky(precision)
    return np.asarray(lsq_linear(root.T, solve_triangular(root, slope, lower=True), (low, high), method="bvls").x)
