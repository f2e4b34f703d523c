"""Limit cycles predicted by the describing function: where L(jω) meets −1/N(M), whether they are stable, how far to trust them.
Method: A. Gelb and W. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, 1968, chapter 3."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import control
import numpy as np
from scipy.optimize import root

from tuning.arrays import Floats
from tuning.limit_cycles.describing_function import FrictionCompliance

# Harmonics at the element's input over the amplitude of its output; above this the describing function is off by more than 10 %.
DOUBTFUL = 0.1
POINTS = 150  # of either curve; between them python-control takes straight lines


@dataclass(frozen=True, slots=True)
class PredictedCycle:
    """One intersection. `amplitude`: M at the element's input, `load_amplitude`: of its output; in the unit of H_c.

    `harmonic_share`: what harmonics 3 to 9 of the output put back on the input, over the load amplitude. The filter hypothesis says
    that it is small.
    """

    frequency_Hz: float
    amplitude: float
    load_amplitude: float
    stable: bool
    harmonic_share: float

    @property
    def doubtful(self) -> bool:
        return self.harmonic_share > DOUBTFUL

    @property
    def warning(self) -> str:
        """Empty where the filter hypothesis holds."""
        if not self.doubtful:
            return ""
        return (
            f"the filter hypothesis fails at {self.frequency_Hz:.2f} Hz: harmonics at the element's input are"
            f" {100 * self.harmonic_share:.0f} % of the load's amplitude; trust the exact simulation"
        )


def predict_limit_cycles(loop: control.TransferFunction, element: FrictionCompliance) -> list[PredictedCycle]:
    """Every intersection of L(jω) with −1/N(M), by frequency: 0.02 to 60 Hz, amplitudes up to a thousand times the smallest."""
    omega = 2.0 * pi * np.geomspace(0.02, 60.0, POINTS)
    amplitude = element.smallest_amplitude * (1.0 + np.geomspace(1e-7, 1e3, POINTS))
    crossings = control.describing_function_response(loop, element, amplitude, omega, refine=False).intersections
    found: list[PredictedCycle] = []
    for start in crossings:
        m, w = _refined(loop, element, start)
        if w > 0.0 and all(abs(w / (2.0 * pi * p.frequency_Hz) - 1.0) > 1e-6 for p in found):
            found.append(_judged(loop, element, w, m))
    return sorted(found, key=lambda prediction: prediction.frequency_Hz)


def _refined(loop: control.TransferFunction, element: FrictionCompliance, start: tuple[float, float]) -> tuple[float, float]:
    """Solve L(jω) N(M) = −1 from a start (M, ω); (0, 0) when there is no solution near it. python-control's own refinement stops
    0.1 % away."""

    def unknowns(v: Floats) -> tuple[float, float]:
        return float(element.smallest_amplitude * (1.0 + np.exp(v[0]))), float(np.exp(v[1]))

    def equations(v: Floats) -> list[float]:
        m, w = unknowns(v)
        value = complex(np.log(-loop(1j * w) * element.describing_function(m)))
        return [value.real, value.imag]

    solution = root(equations, np.log([start[0] / element.smallest_amplitude - 1.0, start[1]]), tol=1e-13)
    return unknowns(solution.x) if np.max(np.abs(solution.fun)) < 1e-9 else (0.0, 0.0)


def _judged(loop: control.TransferFunction, element: FrictionCompliance, w: float, m: float) -> PredictedCycle:
    load = m - element.coulomb
    orders = np.arange(3, 10, 2)
    back = np.abs(loop(1j * w * orders) * element.harmonics(m)[orders - 1]) * m
    return PredictedCycle(w / (2.0 * pi), m, load, _is_stable(loop, element, w, m), float(np.sqrt(np.sum(back**2)) / load))


def _is_stable(loop: control.TransferFunction, element: FrictionCompliance, w: float, m: float) -> bool:
    """Loeb's criterion: a larger amplitude must give a decaying oscillation. From L(−jσ̃) N(M) = −1, growth per amplitude is

    Im(∂ ln N/∂M / ∂ ln L/∂ω).
    """
    dm, dw = 1e-6 * (m - element.smallest_amplitude), 1e-5 * w
    by_amplitude = np.diff(np.log(element.describing_function(np.array([m - dm, m + dm]))))[0] / (2.0 * dm)
    by_frequency = np.diff(np.log(loop(1j * np.array([w - dw, w + dw]))))[0] / (2.0 * dw)
    return bool((by_amplitude / by_frequency).imag < 0.0)


def first_gain_with_cycle(loop: control.TransferFunction, element: FrictionCompliance, low: float, high: float) -> float:
    """Smallest gain factor in [low, high] from which intersections exist (bisection to 1e-3); `high` when there are none."""
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        exists = bool(predict_limit_cycles(middle * loop, element))
        low, high = (low, middle) if exists else (middle, high)
    return high
