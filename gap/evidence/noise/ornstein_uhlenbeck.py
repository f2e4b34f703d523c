"""White noise beside one slowly varying error: covariance C = 1 + δ² exp(−|t − t'| / T), its square root and its determinant in O(n).

An Ornstein-Uhlenbeck process is Markov, so a Kalman filter over the samples factors C without forming it (Särkkä & Svensson 2023,
ch. 12): the innovations divided by their standard deviations are C^(−1/2) y, the sum of the logarithms of their variances is log|C|. A
missing sample is a step without a measurement. What the filter does to y it does to every column of a Jacobian alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gap.data.measured import Array
from gap.data.windows import Experiment


@dataclass(frozen=True, slots=True)
class Filter:
    """The filter of one log: gain and 1/√(innovation variance), windows × samples × channels (0 where nothing was measured), and what
    a step forgets, one number a channel. `log_det`: log|C| of every window and channel."""

    gain: Array
    root: Array
    decay: Array
    log_det: Array

    def of_windows(self, part: slice) -> Filter:
        """The same of some windows."""
        return Filter(self.gain[part], self.root[part], self.decay, self.log_det[part])

    def by_window(self, parts: Sequence[Array]) -> Array:
        """C^(−1/2) of every row; several of numbers × windows × samples × channels, in units of the white noise, 0 where nothing was
        measured → windows × numbers of all parts × values."""
        windows, samples, channels = self.gain.shape
        ends = np.cumsum([0, *map(len, parts)])
        out = np.empty((windows, int(ends[-1]), samples, channels))
        for first, rows in zip(ends[:-1], parts, strict=True):
            _whiten(np.ascontiguousarray(rows), self.gain, self.root, self.decay, int(first), out)
        return out.reshape(windows, int(ends[-1]), samples * channels)

    def side_by_side(self, rows: Array) -> Array:
        """C^(−1/2) of many rows of one channel, windows × samples × numbers: as fast as a processor's vectors are wide."""
        out = np.empty(rows.shape)
        _whiten_many(rows, self.gain[:, :, 0], self.root[:, :, 0], float(self.decay[0]), out)
        return out


def filter_of(there: NDArray[np.bool_], sd: Array, time_s: Array, period_s: float) -> Filter:
    """`there`: windows × samples × channels, what was measured. `sd`: δ in units of the white noise, windows × channels, or one a channel;
    `time_s`: T, one a channel."""
    decay = np.exp(-period_s / np.asarray(time_s, dtype=np.float64))
    variance = np.broadcast_to(np.asarray(sd, dtype=np.float64) ** 2, (there.shape[0], there.shape[2]))
    gain, root = _gains(there, np.ascontiguousarray(variance), decay)
    log_det = -2.0 * np.sum(np.log(np.where(there, root, 1.0)), axis=1)
    return Filter(gain, root, decay, log_det)


def sample_period_s(experiment: Experiment) -> float:
    """Time between the samples compared."""
    return experiment.plan.every * experiment.plan.period_s


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _gains(there: NDArray[np.bool_], variance: Array, decay: Array) -> tuple[Array, Array]:
    windows, samples, channels = there.shape
    gain, root = np.zeros(there.shape), np.zeros(there.shape)
    for w in range(windows):
        for c in range(channels):
            p = variance[w, c]
            for i in range(samples):
                if there[w, i, c]:
                    innovation = p + 1.0
                    gain[w, i, c] = p / innovation
                    root[w, i, c] = 1.0 / np.sqrt(innovation)
                    p = p / innovation
                p = decay[c] ** 2 * p + variance[w, c] * (1.0 - decay[c] ** 2)
    return gain, root


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _whiten(rows: Array, gain: Array, root: Array, decay: Array, first: int, out: Array) -> None:
    numbers, windows, samples, channels = rows.shape
    mean = np.empty(channels)
    for w in range(windows):
        for k in range(numbers):
            mean[:] = 0.0
            for i in range(samples):
                for c in range(channels):
                    innovation = rows[k, w, i, c] - mean[c]
                    out[w, first + k, i, c] = innovation * root[w, i, c]
                    mean[c] = (mean[c] + gain[w, i, c] * innovation) * decay[c]


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _whiten_many(rows: Array, gain: Array, root: Array, decay: float, out: Array) -> None:
    windows, samples, numbers = rows.shape
    mean = np.empty(numbers)
    for w in range(windows):
        mean[:] = 0.0
        for i in range(samples):
            kept, scale = gain[w, i], root[w, i]
            for k in range(numbers):
                innovation = rows[w, i, k] - mean[k]
                out[w, i, k] = innovation * scale
                mean[k] = (mean[k] + kept * innovation) * decay
