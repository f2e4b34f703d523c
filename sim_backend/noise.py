"""Counter-based random numbers: the same seed, sample and channel always give the same number (splitmix64 of Steele et al.)."""

from __future__ import annotations

from math import cos, log, pi, sin, sqrt

import numpy as np

from sim_backend.compiled import compiled

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
def uniform(seed: float, sample: float, channel: int) -> float:
    """A number in (0, 1)."""
    hashed = mixed(mixed(mixed(np.uint64(seed)) ^ np.uint64(sample)) ^ np.uint64(channel))
    return (float(hashed >> _S11) + 0.5) * _TO_UNIT


@compiled
def gaussian_pair(seed: float, sample: float, pair: int) -> tuple[float, float]:
    """Two independent standard normal numbers (Box-Muller) from the two halves of one hash; up to 6.7 standard deviations."""
    hashed = mixed(mixed(mixed(np.uint64(seed)) ^ np.uint64(sample)) ^ np.uint64(pair))
    radius = sqrt(-2.0 * log((float(hashed >> _S32) + 0.5) * _HALF_TO_UNIT))
    angle = 2.0 * pi * (float(hashed & _LOW_HALF) * _HALF_TO_UNIT)
    return radius * cos(angle), radius * sin(angle)
