"""Crossover, phase margin, gain margin and the peak of the sensitivity of a loop given by its frequency response."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, log10, pi

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from tuning.transfer import Complexes, Floats

LoopResponse = Callable[[Floats], Complexes]  # L(jω) at frequencies in rad/s


@dataclass(frozen=True, slots=True)
class Margins:
    """`crossover_Hz` is the highest gain crossover; margins are infinite where nothing crosses."""

    crossover_Hz: float
    phase_margin_deg: float
    gain_margin_dB: float
    sensitivity_peak: float


def margins(loop: LoopResponse, low_Hz: float = 0.01, high_Hz: float = 200.0, points: int = 1500) -> Margins:
    """Smallest margins of all crossovers between the two frequencies, refined by root finding."""
    omega = 2.0 * pi * np.geomspace(low_Hz, high_Hz, points)
    response = loop(omega)

    def at(w: float) -> complex:
        return complex(loop(np.array([w]))[0])

    gain = np.log(np.abs(response))
    crossings = [_root(lambda w: float(np.log(abs(at(w)))), omega, int(i)) for i in np.flatnonzero(gain[:-1] * gain[1:] < 0.0)]
    phases = [180.0 + np.degrees(np.angle(at(w))) for w in crossings]
    phase_margin = min((min(p, 360.0 - p) if p > 180.0 else p for p in phases), default=inf)
    turns = np.flatnonzero((response.imag[:-1] * response.imag[1:] < 0.0) & (response.real[:-1] < 0.0) & (response.real[1:] < 0.0))
    reals = [at(_root(lambda w: at(w).imag, omega, int(i))).real for i in turns]
    gain_margin = min((-20.0 * log10(-r) for r in reals if -1.0 < r < 0.0), default=inf)
    return Margins(max(crossings, default=0.0) / (2.0 * pi), float(phase_margin), float(gain_margin), _peak(at, omega, response))


def _root(function: Callable[[float], float], omega: Floats, i: int) -> float:
    return float(brentq(function, omega[i], omega[i + 1], xtol=1e-12, rtol=1e-13))


def _peak(at: Callable[[float], complex], omega: Floats, response: Complexes) -> float:
    """Largest 1/|1 + L|."""
    i = int(np.argmin(np.abs(1.0 + response)))
    bounds = (omega[max(i - 1, 0)], omega[min(i + 1, omega.size - 1)])
    nearest = minimize_scalar(lambda w: abs(1.0 + at(w)), bounds=bounds, method="bounded", options={"xatol": 1e-9})
    return 1.0 / min(float(nearest.fun), float(np.abs(1.0 + response[i])))
