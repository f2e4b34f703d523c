"""Crossover, phase margin, gain margin and the peak of the sensitivity of a loop given by its frequency response.

Whether the closed loop is stable follows from Nyquist's criterion as Bode diagrams show it: the phase goes down through −180° as often as
up while |L| > 1. So a loop that is stable only between two gains keeps its margins, and an unstable one has margins below zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi

import control
import numpy as np

from tuning.arrays import Complexes, Floats

LoopResponse = Callable[[Floats], Complexes]  # L(jω) at frequencies in rad/s
# For a joint of the paper's pace; between its points python-control interpolates by splines: 1e-6 dB and degrees off on a smooth loop.
GRID_HZ = (0.01, 200.0, 500)
_JUST_AFTER = 1.0001  # a two-hundredth of the grid's step


@dataclass(frozen=True, slots=True)
class Margins:
    """`crossover_Hz` is the highest gain crossover; margins are infinite where nothing crosses.

    Of an unstable loop the gain margin (at most 0) is the least fall of the gain that makes it stable (−∞: none does), and the phase margin
    (below 0) the least lead that brings a crossover back to −180°.
    """

    crossover_Hz: float
    phase_margin_deg: float
    gain_margin_dB: float
    sensitivity_peak: float


def margins(loop: LoopResponse, pace: float = 1.0) -> Margins:
    """Smallest margins of all crossovers between 0.01 and 200 Hz, largest 1/|1 + L|; of a joint `pace` times as fast as the paper's,
    so many times as high. The loop without feedback must be stable, but for integrators."""
    omega = grid(pace)
    response = loop(omega)
    measured = control.frd(response, omega, smooth=True)
    gain, phase, distance, at, crossover, _ = control.stability_margins(measured, returnall=True)
    factor, stable = _allowed_factor(*_passages(measured, response[0], gain, at))
    with np.errstate(divide="ignore"):
        gain_margin_dB = float(20.0 * np.log10(factor))
    return Margins(
        float(max(crossover, default=0.0)) / (2.0 * pi),
        float(min(abs(phase), default=inf) if stable else -min(-phase % 360.0, default=inf)),
        gain_margin_dB,
        float(1.0 / min(*distance, *np.abs(1.0 + response))),
    )


def grid(pace: float) -> Floats:
    """Frequencies in rad/s."""
    return np.asarray(2.0 * pi * pace * np.geomspace(*GRID_HZ), dtype=np.float64)


def _passages(measured: control.FrequencyResponseData, first: complex, gain: Floats, at: Floats) -> tuple[Floats, Floats]:
    """Factors of the gain at which −1 lies on the loop, with +1 where its phase goes down through −180° there and −1 where up. A loop that
    begins beyond −180° (two integrators and a lag) has gone down below the first frequency."""
    way = np.sign(np.imag(measured(1j * at * _JUST_AFTER))) if len(at) else np.zeros(0)
    if np.angle(first) > 0.5 * pi:
        return np.append(gain, 0.0), np.append(way, 1.0)
    return gain, way


def _allowed_factor(gain: Floats, way: Floats) -> tuple[float, bool]:
    """The factor of the gain at which the loop stops being stable, or else the nearest smaller one at which it is; and whether it is."""
    if way[gain < 1.0].sum() == 0.0:
        return float(min(gain[gain > 1.0], default=inf)), True
    order = np.argsort(gain)
    gain, way = gain[order], way[order]
    stable_below = (np.cumsum(way) - way == 0.0) & (gain < 1.0)
    return float(gain[stable_below].max()), False
