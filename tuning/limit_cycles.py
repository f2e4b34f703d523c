"""Limit cycles predicted by the describing function: where L(jω) meets −1/N(M), whether they are stable, how far to trust them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import pi

import numpy as np
from scipy.optimize import root

from tuning.describing_function import FrictionCompliance
from tuning.margins import LoopResponse
from tuning.transfer import Complexes, Floats

# Harmonics at the element's input over the amplitude of its output; above this the describing function is off by more than 10 %.
DOUBTFUL = 0.1


@dataclass(frozen=True, slots=True)
class Prediction:
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


def predict_limit_cycles(
    loop: LoopResponse, element: FrictionCompliance, low_Hz: float = 0.02, high_Hz: float = 60.0, largest_amplitude: float = 1e3
) -> list[Prediction]:
    """Every intersection of L(jω) with −1/N(M), by frequency. `largest_amplitude` in multiples of (H_s + H_c)/2."""
    omega = 2.0 * pi * np.geomspace(low_Hz, high_Hz, 700)
    excess = np.geomspace(1e-7, largest_amplitude, 700)
    amplitude = element.smallest_amplitude * (1.0 + excess)
    starts = _crossings(_log_plane(loop(omega)), _log_plane(-1.0 / element.describing_function(amplitude)), omega, excess)
    found: list[Prediction] = []
    for start in starts:
        w, m = _refined(loop, element, start)
        if w > 0.0 and all(abs(w / (2.0 * pi * p.frequency_Hz) - 1.0) > 1e-6 for p in found):
            found.append(_judged(loop, element, w, m))
    return sorted(found, key=lambda prediction: prediction.frequency_Hz)


def _log_plane(response: Complexes) -> Complexes:
    """ln|·| + j phase with the phase in (−2π, 0], where both curves are smooth."""
    phase = np.angle(response)
    return np.asarray(np.log(np.abs(response)) + 1j * np.where(phase > 0.0, phase - 2.0 * pi, phase))


def _crossings(one: Complexes, other: Complexes, x: Floats, y: Floats) -> list[tuple[float, float]]:
    """(x, y) near every crossing of the two polylines one(x) and other(y)."""
    a, da = one[:-1, None], np.diff(one)[:, None]
    b, db = other[None, :-1], np.diff(other)[None, :]
    cross = (np.conj(da) * db).imag
    with np.errstate(divide="ignore", invalid="ignore"):
        s, t = (np.conj(b - a) * db).imag / cross, (np.conj(b - a) * da).imag / cross
    hits = np.argwhere((s >= 0.0) & (s < 1.0) & (t >= 0.0) & (t < 1.0) & (np.abs(da) < 1.0) & (np.abs(db) < 1.0))
    return [(float(x[i]), float(y[j])) for i, j in hits]


def _refined(loop: LoopResponse, element: FrictionCompliance, start: tuple[float, float]) -> tuple[float, float]:
    """Solve L(jω) N(M) = −1 from a start (ω, excess); (0, 0) when there is no solution near it."""

    def unknowns(v: Floats) -> tuple[float, float]:
        return float(np.exp(v[0])), float(element.smallest_amplitude * (1.0 + np.exp(v[1])))

    def equations(v: Floats) -> list[float]:
        w, m = unknowns(v)
        value = complex(np.log(-(loop(np.array([w])) * element.describing_function(m))[0]))
        return [value.real, value.imag]

    solution = root(equations, np.log(start), tol=1e-13)
    return unknowns(solution.x) if np.max(np.abs(solution.fun)) < 1e-9 else (0.0, 0.0)


def _judged(loop: LoopResponse, element: FrictionCompliance, w: float, m: float) -> Prediction:
    load = m - element.coulomb
    orders = np.arange(3, 10, 2)
    back = np.abs(loop(np.asarray(w * orders, dtype=np.float64)) * element.harmonics(m)[orders - 1]) * m
    return Prediction(w / (2.0 * pi), m, load, _is_stable(loop, element, w, m), float(np.sqrt(np.sum(back**2)) / load))


def _is_stable(loop: LoopResponse, element: FrictionCompliance, w: float, m: float) -> bool:
    """Loeb: a larger amplitude must give a decaying oscillation. From L(−jσ̃)N(M) = −1: growth per amplitude = Im(∂ ln N/∂M / ∂ ln L/∂ω)."""
    dm, dw = 1e-6 * (m - element.smallest_amplitude), 1e-5 * w
    by_amplitude = np.diff(np.log(element.describing_function(np.array([m - dm, m + dm]))))[0] / (2.0 * dm)
    by_frequency = np.diff(np.log(loop(np.array([w - dw, w + dw]))))[0] / (2.0 * dw)
    return bool((by_amplitude / by_frequency).imag < 0.0)


def first_gain_with_cycle(loop: LoopResponse, element: FrictionCompliance, low: float, high: float) -> float:
    """Smallest gain factor in [low, high] from which intersections exist (bisection to 1e-3); `high` when there are none."""
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        exists = bool(predict_limit_cycles(partial(_scaled, loop, middle), element))
        low, high = (low, middle) if exists else (middle, high)
    return high


def _scaled(loop: LoopResponse, factor: float, omega: Floats) -> Complexes:
    return factor * loop(omega)
