"""Value, rate and acceleration of a measured motion at every row, from the longest local polynomial that follows it to within the noise.

A fixed span either keeps the noise or cuts the corners of quick motion: a wave of 40 Hz seen through a parabola of 30 ms has lost
most of its velocity, and a window that starts with that velocity is charged for it, however right its model.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.ndimage import correlate1d

from gap.data.measured import Array

_LEAST_HALF = 2  # rows on either side: a cubic needs five
_SHORTER = 0.8  # ratio of one span to the one before
_WITHIN = 3.0  # standard deviations of a sum of squares up to which it counts as noise


def rate_noise(order: int, half: int, period_s: float) -> float:
    """Standard deviation of the rate at the middle of 2 half + 1 rows, for a noise of 1."""
    return float(np.linalg.norm(np.linalg.pinv(_powers(order, half))[1]) / period_s)


def local_motion(read: Array, sigma: float, period_s: float, longest: int, rate_sd: float) -> tuple[Array, Array, Array]:
    """Value, rate and acceleration at every row of `read` (NaN next to rows that are NaN).

    Tried in turn: a parabola over the `longest` half span in rows, a cubic over the same, cubics over shorter ones, as long as noise
    `sigma` moves the rate by no more than `rate_sd`. The first that leaves a sum of squares as noise does is taken, else the last.
    """
    middle = float(np.nanmean(read))
    y = read - middle
    found = np.full((3, len(y)), np.nan)
    open_ = np.ones(len(y), dtype=bool)
    for order, half in _spans(longest, sigma, period_s, rate_sd):
        there, rest = _fitted(y, order, half)
        freedom = 2 * half - order
        found[:, open_] = there[:, open_]
        open_ &= ~(rest <= sigma**2 * (freedom + _WITHIN * np.sqrt(2.0 * freedom)))
        if not open_.any():
            break
    return found[0] + middle, found[1] / period_s, found[2] / period_s**2


def _spans(longest: int, sigma: float, period_s: float, rate_sd: float) -> Iterator[tuple[int, int]]:
    """Order and half span of every polynomial to try."""
    yield 2, longest
    half = longest
    while half >= _LEAST_HALF and sigma * rate_noise(3, half, period_s) <= rate_sd:
        yield 3, half
        half = min(half - 1, round(_SHORTER * half))


def _fitted(y: Array, order: int, half: int) -> tuple[Array, Array]:
    """Value, first and second difference quotient a row at every row, and the sum of squares that the polynomial leaves."""
    basis, triangle = np.linalg.qr(_powers(order, half))
    parts = np.stack([correlate1d(y, basis[:, k], mode="nearest") for k in range(order + 1)])
    coefficients = np.linalg.solve(triangle, parts)
    rest = correlate1d(y * y, np.ones(2 * half + 1), mode="nearest") - np.sum(parts**2, axis=0)
    return coefficients[:3] * np.array([[1.0], [1.0], [2.0]]), rest


def _powers(order: int, half: int) -> Array:
    return np.asarray(np.vander(np.arange(-half, half + 1), order + 1, increasing=True), dtype=np.float64)
