"""Rational transfer functions with an optional dead time: frequency response, products, state space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class TransferFunction:
    """numerator(s) / denominator(s) · exp(−s delay_s); coefficients from the highest power down."""

    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    delay_s: float = 0.0

    def __call__(self, s: ArrayLike) -> Complexes:
        """Value at complex frequencies s (rad/s)."""
        s = np.asarray(s, dtype=np.complex128)
        return np.asarray(np.polyval(self.numerator, s) / np.polyval(self.denominator, s) * np.exp(-s * self.delay_s))

    def __mul__(self, other: TransferFunction) -> TransferFunction:
        """Both in series."""
        top, bottom = np.polymul(self.numerator, other.numerator), np.polymul(self.denominator, other.denominator)
        return TransferFunction(tuple(map(float, top)), tuple(map(float, bottom)), self.delay_s + other.delay_s)

    def scaled(self, factor: float) -> TransferFunction:
        return TransferFunction(tuple(factor * c for c in self.numerator), self.denominator, self.delay_s)

    def delayed(self, delay_s: float) -> TransferFunction:
        """With so much more dead time."""
        return TransferFunction(self.numerator, self.denominator, self.delay_s + delay_s)

    def state_space(self) -> tuple[Floats, Floats, Floats]:
        """(A, b, c) of the part without dead time in controller form; the function must be strictly proper."""
        bottom = np.asarray(self.denominator, dtype=np.float64)
        order = bottom.size - 1
        top = np.concatenate([np.zeros(order - len(self.numerator)), self.numerator]) / bottom[0]
        a = np.zeros((order, order))
        a[0] = -bottom[1:] / bottom[0]
        a[1:, :-1] = np.eye(order - 1)
        return a, np.eye(order)[0], top


# Eq 4 of the paper: rotary joint, valve command (V) to position; degrees per volt (the paper gives no units).
EQ4 = TransferFunction((240810.0,), (1.0, 140.0, 6150.0, 0.0))


def lag_lead(gain: float, sections: tuple[tuple[float, float], ...]) -> TransferFunction:
    """gain · Π (1 + s/zero)/(1 + s/pole), corners in rad/s as (zero, pole)."""
    result = TransferFunction((gain,), (1.0,))
    for zero, pole in sections:
        result = result * TransferFunction((1.0 / zero, 1.0), (1.0 / pole, 1.0))
    return result
