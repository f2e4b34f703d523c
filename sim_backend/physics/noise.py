"""Counter-based random numbers: the same seed, sample and channel always give the same number (splitmix64 of
G. Steele, D. Lea and C. Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014)."""

from __future__ import annotations

from math import floor, log, pi, sqrt

import numpy as np

from sim_backend.memory.compiled import compiled

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_S32, _LOW_HALF = np.uint64(32), np.uint64(0xFFFFFFFF)
_TO_UNIT = 2.0**-53
_HALF_TO_UNIT = 2.0**-32


@compiled
def mixed(value: np.uint64) -> np.uint64:
    """The splitmix64 finaliser."""
    value = value + _GOLDEN
    value = (value ^ (value >> _S30)) * _MIX_1
    value = (value ^ (value >> _S27)) * _MIX_2
    return value ^ (value >> _S31)


@compiled
def sample_key(seed: float, sample: float) -> np.uint64:
    """What all channels of one sample share."""
    return mixed(mixed(np.uint64(seed)) ^ np.uint64(sample))


@compiled
def uniform(seed: float, sample: float, channel: int) -> float:
    """A number in (0, 1)."""
    hashed = mixed(sample_key(seed, sample) ^ np.uint64(channel))
    return (float(hashed >> _S11) + 0.5) * _TO_UNIT


@compiled
def turned(share: float) -> tuple[float, float]:
    """Cosine and sine of a share (0 to 1) of a full turn, within 1e-12: their series about the nearest quarter."""
    quarter = floor(4.0 * share + 0.5)
    angle = 2.0 * pi * (share - 0.25 * quarter)
    q = angle * angle
    cosine = 1.0 + q * (-1 / 2 + q * (1 / 24 + q * (-1 / 720 + q * (1 / 40320 + q * (-1 / 3628800 + q / 479001600)))))
    sine = angle * (1.0 + q * (-1 / 6 + q * (1 / 120 + q * (-1 / 5040 + q * (1 / 362880 + q * (-1 / 39916800 + q / 6227020800))))))
    if quarter == 1.0:
        return -sine, cosine
    if quarter == 2.0:
        return -cosine, -sine
    if quarter == 3.0:
        return sine, -cosine
    return cosine, sine


@compiled
def gaussian_pair(key: np.uint64, pair: int) -> tuple[float, float]:
    """Two independent standard normal numbers (G. Box and M. Muller, Annals of Math. Statistics 29, 1958) from the two halves
    of one hash; up to 6.7 standard deviations.

    `key`: sample_key()."""
    hashed = mixed(key ^ np.uint64(pair))
    radius = sqrt(-2.0 * log((float(hashed >> _S32) + 0.5) * _HALF_TO_UNIT))
    cosine, sine = turned(float(hashed & _LOW_HALF) * _HALF_TO_UNIT)
    return radius * cosine, radius * sine
