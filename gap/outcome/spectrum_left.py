"""Spectrum of what a model leaves in a channel, pooled over logs that may be sampled at different rates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gap.data.measured import Array
from gap.fitting.evaluation import Evaluation

_BAND = (0.05, 0.95)  # cumulated excess between which the band lies


def band(evaluations: Sequence[Evaluation], channel: int) -> tuple[float, float]:
    """Frequencies (Hz) between which nine tenths of the excess over the noise lie; zeros where there is none."""
    frequency, density = spectrum(evaluations, channel)
    if frequency.size == 0:
        return (0.0, 0.0)
    excess = np.cumsum(np.maximum(density - 1.0, 0.0))
    if excess[-1] <= 0:
        return (0.0, 0.0)
    low, high = (int(np.searchsorted(excess / excess[-1], level)) for level in _BAND)
    return (round(float(frequency[low]), 2), round(float(frequency[min(high, len(frequency) - 1)]), 2))


def spectrum(evaluations: Sequence[Evaluation], channel: int) -> tuple[Array, Array]:
    """Frequencies (Hz) and mean power of what is left in a channel over that of white noise at its floor.

    Every log has a grid of its own, up to half the rate at which it is compared. The log that reaches highest gives the common one; at each
    of its frequencies the mean is taken over the windows of the logs that reach it.
    """
    found = [(*_of_log(e, channel), count) for e in evaluations if (count := int(_there(e, channel).sum()))]
    if not found:
        return np.empty(0), np.empty(0)
    grid = max((frequency for frequency, _, _ in found), key=lambda frequency: float(frequency[-1]))
    weight, total = np.zeros(len(grid)), np.zeros(len(grid))
    for frequency, density, count in found:
        reached = grid <= frequency[-1] * (1 + 1e-9)
        weight[reached] += count
        total[reached] += count * np.interp(grid[reached], frequency, density)
    return grid, total / weight


def left_of(evaluation: Evaluation, channel: int) -> Array:
    """What is left of one channel in noise units, windows × samples; NaN where nothing was measured."""
    measured = evaluation.experiment.measured
    left = evaluation.left[:, : measured[0].size].reshape(measured.shape)[:, :, channel]
    return np.where(np.isfinite(measured[:, :, channel]), left, np.nan)


def _there(evaluation: Evaluation, channel: int) -> NDArray[np.bool_]:
    """Windows in which the channel was measured throughout."""
    return np.asarray(np.isfinite(evaluation.experiment.measured[:, :, channel]).all(axis=1))


def _of_log(evaluation: Evaluation, channel: int) -> tuple[Array, Array]:
    """Periodograms (Hann) of the log's windows, without the mean; their mean is P. Welch's estimate (IEEE Trans. Audio AU-15, 1967)."""
    plan = evaluation.experiment.plan
    taper = np.hanning(plan.samples)
    values = left_of(evaluation, channel)[_there(evaluation, channel)]
    density = (np.abs(np.fft.rfft(values * taper, axis=1)) ** 2).mean(axis=0) / np.sum(taper**2)
    frequency = np.fft.rfftfreq(plan.samples, plan.every * plan.period_s)
    return np.asarray(frequency[1:], dtype=np.float64), np.asarray(density[1:], dtype=np.float64)
