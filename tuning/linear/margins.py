"""Crossover, phase margin, gain margin and the peak of the sensitivity of a loop given by its frequency response."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi

import control
import numpy as np

from tuning.arrays import Complexes, Floats

LoopResponse = Callable[[Floats], Complexes]  # L(jω) at frequencies in rad/s
GRID_HZ = (0.01, 200.0, 500)  # between its points python-control interpolates by splines: 1e-6 dB and degrees off on a smooth loop


@dataclass(frozen=True, slots=True)
class Margins:
    """`crossover_Hz` is the highest gain crossover; margins are infinite where nothing crosses."""

    crossover_Hz: float
    phase_margin_deg: float
    gain_margin_dB: float
    sensitivity_peak: float


def margins(loop: LoopResponse) -> Margins:
    """Smallest margins of all crossovers between 0.01 and 200 Hz, largest 1/|1 + L|."""
    omega = 2.0 * pi * np.geomspace(*GRID_HZ)
    response = loop(omega)
    measured = control.frd(response, omega, smooth=True)
    gain, phase, distance, _, crossover, _ = control.stability_margins(measured, returnall=True)
    return Margins(
        float(max(crossover, default=0.0)) / (2.0 * pi),
        float(min(abs(phase), default=inf)),
        float(min(20.0 * np.log10(gain[gain > 1.0]), default=inf)),
        float(1.0 / min(*distance, *np.abs(1.0 + response))),
    )
