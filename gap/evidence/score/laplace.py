"""Laplace's approximation of a marginal likelihood (MacKay, *Information Theory, Inference and Learning Algorithms*, ch. 28).

About the largest log p(y, φ), with H the precision there,

    log Z ≈ log p(y, φ̂) + ½ d ln 2π − ½ log|H|

exact where the model is linear and everything normal. A number may end at the end of its range, or near it: then only a part of the normal
lies inside. That part is taken number by number, with the others answering.
"""

from __future__ import annotations

import numpy as np
from scipy.special import erfcx, log_ndtr

from gap.data.measured import Array
from gap.fitting.bounded_step import bounded

AT_END = 1e-9  # of a coordinate's own unit


def log_evidence(log_density: float, precision: Array, slope: Array, phi: Array, low: Array, high: Array) -> float:
    """`log_density`: ln p(y, φ̂) without the −½ ln 2π of each prior. `slope`: its gradient, 0 at a free maximum and outward at an end."""
    sign, log_det = np.linalg.slogdet(precision)
    assert sign > 0
    return log_density - 0.5 * float(log_det) + truncated(precision, slope, phi, low, high)


def truncated(precision: Array, slope: Array, phi: Array, low: Array, high: Array) -> float:
    """ln of the share of the normal that lies within the ranges, beside what the value at the end of a range stands for."""
    if not len(phi):
        return 0.0
    width = np.sqrt(np.diag(np.linalg.inv(precision)))
    to_low, to_high = (phi - low) / width, (high - phi) / width
    inside = np.zeros(len(phi))
    for k in range(len(phi)):
        if min(to_low[k], to_high[k]) * width[k] <= AT_END:
            outward = -slope[k] if to_low[k] <= to_high[k] else slope[k]
            inside[k] = np.log(0.5 * erfcx(max(outward, 0.0) * width[k] / np.sqrt(2.0)))
        else:
            inside[k] = log_share(-to_low[k], to_high[k])
    return float(inside.sum())


def added(inner: Array, mixed: Array, low: Array, high: Array, precision: Array) -> float:
    """What numbers more add to log Z, beside a normal posterior of all others.

    `inner`: sᵀΣ⁻¹s less what the others do of it (Schur's complement), `mixed`: sᵀΣ⁻¹r likewise; `precision` of their priors about 0, which
    end at `low` and `high`.
    """
    h = inner + np.diag(precision)
    step = bounded(h, mixed, low, high)
    gained = float(mixed @ step - 0.5 * step @ h @ step) + 0.5 * float(np.sum(np.log(precision)) - np.linalg.slogdet(h)[1])
    prior_share = sum(log_share(*each) for each in zip(low, high, precision, strict=True))
    return gained + truncated(h, mixed - h @ step, step, low, high) - prior_share


def log_share(low: float, high: float, precision: float = 1.0) -> float:
    """ln of what of a normal about 0 lies between `low` and `high`, accurate in both tails."""
    a, b = low * np.sqrt(precision), high * np.sqrt(precision)
    if a > 0:
        a, b = -b, -a
    upper = log_ndtr(b)
    return float(upper + np.log1p(-np.exp(min(log_ndtr(a) - upper, -1e-300))))
