"""Friction behind a compliant drive train: the element of Eqs 2 and 3 of the paper, (T1) of docs/method/tuning.md.

A massless output is held by friction and driven through a spring by x = M sin φ. H_s (stiction) and H_c (Coulomb) are friction
over stiffness, so they are input displacements. Sliding, the output trails the input by H_c; when the input turns, it rests; it breaks
away when the spring force has reached −H_s, that is after the input has gone back by H_s + H_c, and jumps by H_s − H_c.
Eqs 2, 3a and 3b are right as printed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from tuning.arrays import Complexes, Floats


@dataclass(frozen=True, slots=True)
class FrictionCompliance:
    """`stiction`: H_s, `coulomb`: H_c, both as input displacement (any unit, the same for both)."""

    stiction: float
    coulomb: float

    @staticmethod
    def of_ratio(ratio: float) -> FrictionCompliance:
        """H_c = 1 and H_s = ratio, so that amplitudes are in H_c."""
        return FrictionCompliance(ratio, 1.0)

    @property
    def smallest_amplitude(self) -> float:
        """Input amplitude below which a steady oscillation never moves the output: (H_s + H_c)/2."""
        return 0.5 * (self.stiction + self.coulomb)

    def describing_function(self, amplitude: ArrayLike) -> Complexes:
        """N = b₁/M + j a₁/M (Eqs 2, 3a, 3b); 0 where the output never moves."""
        m = np.asarray(amplitude, dtype=np.float64)
        ratio = self.stiction / self.coulomb
        h = self.coulomb / np.maximum(m, self.smallest_amplitude)
        r = h * (1.0 + ratio)
        imaginary = 4.0 * h * r - 4.0 * h - r**2
        real = 0.5 * pi + np.arcsin(np.clip(1.0 - r, -1.0, 1.0)) + (1.0 - h * (3.0 - ratio)) * np.sqrt(np.maximum(2.0 * r - r**2, 0.0))
        return np.asarray(np.where(m >= self.smallest_amplitude, (real + 1j * imaginary) / pi, 0.0))

    def response(self, phase: ArrayLike, amplitude: float) -> Floats:
        """The output over one steady period for the input amplitude · sin(phase); phase in rad."""
        angle = np.mod(np.asarray(phase, dtype=np.float64), 2.0 * pi)
        x = amplitude * np.sin(angle)
        travel = self.stiction + self.coulomb
        if amplitude < self.smallest_amplitude:
            return np.zeros_like(x)
        top = amplitude - self.coulomb
        breakaway = pi - np.arcsin((amplitude - travel) / amplitude)  # phase at which the input has gone back by H_s + H_c
        down = np.where(angle < breakaway, top, x + self.coulomb)
        after = np.mod(angle - 0.5 * pi, 2.0 * pi)  # phase since the upper reversal
        opposite = np.where(np.mod(angle - pi, 2.0 * pi) < breakaway, -top, x - self.coulomb)
        return np.asarray(np.where(after < pi, down, opposite))

    def harmonics(self, amplitude: float, count: int = 9, samples: int = 16384) -> Complexes:
        """Complex amplitudes of harmonics 1…count of the output, over the input amplitude: entry 0 is N."""
        phase = 2.0 * pi * (np.arange(samples) + 0.5) / samples
        lines = np.fft.rfft(self.response(phase, amplitude)) / (0.5 * samples * amplitude)
        orders = np.arange(1, count + 1)
        return np.asarray(1j * lines[orders] * np.exp(-1j * orders * pi / samples))
