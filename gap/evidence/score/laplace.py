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
        nearest = min(to_low[k], to_high[k])
        if nearest * width[k] <= AT_END:
            outward = -slope[k] if to_low[k] <= to_high[k] else slope[k]
            inside[k] = np.log(0.5 * erfcx(max(outward, 0.0) * width[k] / np.sqrt(2.0)))
        else:
            inside[k] = log_ndtr(nearest)
    return float(inside.sum())


def added(inner: float, mixed: float, low: float, high: float, precision: float) -> tuple[float, float]:
    """One number more, beside a normal posterior of all others: its best value within (low, high) and what it adds to log Z.

    `inner`: s'Σ⁻¹s less what the others do of it (Schur's complement), `mixed`: s'Σ⁻¹r likewise, `precision` of its prior about 0.
    """
    h = inner + precision
    best = mixed / h
    width = 1.0 / np.sqrt(h)
    clipped = float(np.clip(best, low, high))
    share = _log_share((low - best) / width, (high - best) / width)
    prior_share = _log_share(low * np.sqrt(precision), high * np.sqrt(precision))
    return clipped, float(0.5 * mixed**2 / h + 0.5 * np.log(precision / h) + share - prior_share)


def _log_share(a: float, b: float) -> float:
    """ln(Φ(b) − Φ(a)), accurate in both tails."""
    if a > 0:
        a, b = -b, -a
    upper = log_ndtr(b)
    return float(upper + np.log1p(-np.exp(min(log_ndtr(a) - upper, -1e-300))))
