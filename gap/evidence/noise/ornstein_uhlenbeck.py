"""White noise beside one slowly varying error: covariance C = 1 + δ² exp(−|t − t'| / T), its inverse and its determinant in O(n).

An Ornstein-Uhlenbeck process is Markov, so a Kalman filter over the samples factors C without forming it (Särkkä & Svensson 2023,
ch. 12): the innovations divided by their standard deviations are C^(−1/2) y, the sum of the logarithms of their variances is log|C|. A
missing sample is a step without a measurement. What the filter does to y it does to every column of a Jacobian alike. The same steps
backwards, transposed, give C⁻¹ y.

δ and T stand on the rungs of a ladder, so that what C⁻¹ does to rows that stay the same can be kept (whitening).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gap.data.measured import Array
from gap.data.windows import Experiment

OCTAVE = 5  # rungs of the ladder that double a value
_RUNG = np.log(2.0) / OCTAVE


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

    def applied(self, rows: Array) -> tuple[Array, Array]:
        """C^(−1/2) and C⁻¹ of rows × windows × samples × channels, in units of the white noise, 0 where nothing was measured → windows ×
        values × rows."""
        windows, samples, channels = self.gain.shape
        white, solved = (np.empty((windows, samples, channels, len(rows))) for _ in range(2))
        _apply(np.ascontiguousarray(np.moveaxis(rows, 0, -1)), self.gain, self.root, self.decay, white, solved)
        flat = (windows, samples * channels, len(rows))
        return white.reshape(flat), solved.reshape(flat)


def rung(value: Array | float) -> NDArray[np.int64]:
    """The ladder's rung next to a value."""
    return np.asarray(np.rint(np.log(value) / _RUNG), dtype=np.int64)


def at_rung(number: NDArray[np.int64] | int) -> Array:
    """The value at a rung."""
    return np.asarray(np.exp(_RUNG * np.asarray(number, dtype=np.float64)))


def filter_of(there: NDArray[np.bool_], sd: Array, time_s: Array, period_s: float) -> Filter:
    """`there`: windows × samples × channels, what was measured. `sd`: δ in units of the white noise, windows × channels, or one a channel;
    `time_s`: T, one a channel."""
    decay = np.exp(-period_s / np.asarray(time_s, dtype=np.float64))
    variance = np.broadcast_to(np.asarray(sd, dtype=np.float64) ** 2, (there.shape[0], there.shape[2]))
    gain, root = np.zeros(there.shape), np.zeros(there.shape)
    for c in range(there.shape[2]):
        own = gains(np.ascontiguousarray(there[:, :, c].T), np.ascontiguousarray(variance[:, c]), float(decay[c]))
        gain[:, :, c], root[:, :, c] = own[0].T, own[1].T
    log_det = -2.0 * np.sum(np.log(np.where(there, root, 1.0)), axis=1)
    return Filter(gain, root, decay, log_det)


def sample_period_s(experiment: Experiment) -> float:
    """Time between the samples compared."""
    return experiment.plan.every * experiment.plan.period_s


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def gains(there: NDArray[np.bool_], variance: Array, decay: float) -> tuple[Array, Array]:
    """Gain and 1/√(innovation variance) of one channel, samples × windows, all windows side by side; `variance`: δ² of each window."""
    samples, windows = there.shape
    gain, root = np.zeros(there.shape), np.zeros(there.shape)
    p, fresh = variance.copy(), (1.0 - decay**2) * variance
    for i in range(samples):
        for w in range(windows):
            seen = 1.0 if there[i, w] else 0.0
            gain[i, w] = seen * p[w] / (p[w] + 1.0)
            root[i, w] = seen / np.sqrt(p[w] + 1.0)
            p[w] = decay**2 * p[w] * (1.0 - gain[i, w]) + fresh[w]
    return gain, root


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def whitened(rows: Array, gain: Array, root: Array, decay: float) -> Array:
    """C^(−1/2) of many rows of one channel, windows × samples × numbers: as fast as a processor's vectors are wide."""
    windows, samples, numbers = rows.shape
    mean, out = np.empty(numbers), np.empty(rows.shape)
    for w in range(windows):
        mean[:] = 0.0
        for i in range(samples):
            kept, scale = gain[i, w], root[i, w]
            for k in range(numbers):
                innovation = rows[w, i, k] - mean[k]
                out[w, i, k] = innovation * scale
                mean[k] = (mean[k] + kept * innovation) * decay
    return out


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def solved(left: Array, gain: Array, root: Array, decay: float) -> tuple[Array, Array]:
    """C⁻¹ x of one row x of one channel, samples × windows, all windows side by side, and xᵀ C⁻¹ x of every window."""
    samples, windows = left.shape
    out, mean, squares = np.empty(left.shape), np.zeros(windows), np.zeros(windows)
    for i in range(samples):
        for w in range(windows):
            innovation = left[i, w] - mean[w]
            out[i, w] = innovation * root[i, w]
            mean[w] = (mean[w] + gain[i, w] * innovation) * decay
    mean[:] = 0.0
    for i in range(samples - 1, -1, -1):
        for w in range(windows):
            squares[w] += out[i, w] ** 2
            onward = decay * mean[w]
            out[i, w] = out[i, w] * root[i, w] + gain[i, w] * onward
            mean[w] = onward - out[i, w]
    return out, squares


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _apply(rows: Array, gain: Array, root: Array, decay: Array, white: Array, solved: Array) -> None:
    """With e_i = x_i − m_i and m_(i+1) = φ (m_i + g_i e_i) forwards, the transposed recursion backwards. Rows x come last: what is done to
    one is done to all side by side."""
    windows, samples, channels, numbers = rows.shape
    mean = np.empty((channels, numbers))
    for w in range(windows):
        mean[:] = 0.0
        for i in range(samples):
            for c in range(channels):
                kept, scale, forget = gain[w, i, c], root[w, i, c], decay[c]
                for k in range(numbers):
                    innovation = rows[w, i, c, k] - mean[c, k]
                    white[w, i, c, k] = innovation * scale
                    mean[c, k] = (mean[c, k] + kept * innovation) * forget
        mean[:] = 0.0
        for i in range(samples - 1, -1, -1):
            for c in range(channels):
                kept, scale, forget = gain[w, i, c], root[w, i, c], decay[c]
                for k in range(numbers):
                    onward = forget * mean[c, k]
                    own = white[w, i, c, k] * scale + kept * onward
                    solved[w, i, c, k] = own
                    mean[c, k] = onward - own
