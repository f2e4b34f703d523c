"""A measured frequency response from command (V) to joint position (rad or m): what it is, and how a sweep and a multisine give it.

The command is held over a period, so measured values are divided by the hold's e^{−jωT/2} sin(ωT/2)/(ωT/2): what is left is the
continuous joint with its valve. With the servo closed the excitation is the instrument: noise that goes round the loop drops out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from config.errors import LogError
from tuning.arrays import Complexes, Floats
from tuning.experiments.excited_run import ExcitedRun, ResponseConditions

SMOOTHED_SHARE = 0.03  # of the frequency over which a sweep's lines are averaged, on either side
FEWEST_LINES = 5  # averaged where that share holds fewer
SWEEP_POINTS = 60
USED_BAND = (1.3, 0.75)  # of a sweep's band: its ends are excited by the fades alone


@dataclass(frozen=True, slots=True, eq=False)
class Distortion:
    """Output at lines that were not excited, corrected for what the servo put in there: amplitude over that of the excited lines
    nearby, in dB; and the level that noise alone would have."""

    frequencies_Hz: Floats
    level_dB: Floats
    noise_dB: Floats


@dataclass(frozen=True, slots=True, eq=False)
class FrequencyResponse:
    """`response` complex, position over command; `sigma` its relative standard deviation from noise; `coherence` 0 to 1; `command_V`
    the amplitude that reached the valve (the servo takes part of a slow excitation away). `odd` and `even`: distortion at the lines
    left out of a multisine; None for a sweep.
    """

    source: str
    conditions: ResponseConditions
    frequencies_Hz: Floats
    response: Complexes
    sigma: Floats
    coherence: Floats
    command_V: Floats
    odd: Distortion | None = None
    even: Distortion | None = None


def without_hold(frequencies_Hz: Floats, response: Complexes, period_s: float) -> Complexes:
    """The response with the hold of the command taken out."""
    half = np.pi * frequencies_Hz * period_s
    return np.asarray(response * np.exp(1j * half) / np.sinc(half / np.pi), dtype=np.complex128)


def sweep_response(run: ExcitedRun) -> FrequencyResponse:
    """Cross-spectra with the excitation over the whole record (it begins and ends at rest, so nothing leaks), averaged over
    neighbouring lines. LogError when the record is too short for its lowest frequency."""
    lines_Hz = np.fft.rfftfreq(len(run.excitation), run.period_s)
    r, u, y = (np.fft.rfft(values - _drift(values)) for values in (run.excitation, run.command, run.position))
    edges = sorted((run.maneuver["from"], run.maneuver["to"]))
    wanted = np.geomspace(USED_BAND[0] * edges[0], USED_BAND[1] * edges[1], SWEEP_POINTS)
    spacing = float(lines_Hz[1])
    wanted = wanted[wanted > FEWEST_LINES * spacing]
    if not len(wanted):
        raise LogError("the sweep is too short to resolve its frequencies", value=len(run.excitation) * run.period_s, unit="s")
    rows = [np.abs(lines_Hz - f) <= max(SMOOTHED_SHARE * f, 0.5 * FEWEST_LINES * spacing) for f in wanted]
    table = np.array([_cross(r[row], u[row], y[row], lines_Hz[row], f) for row, f in zip(rows, wanted, strict=True)])
    response = without_hold(wanted, table[:, 0] + 1j * table[:, 1], run.period_s)
    command = run.conditions.amplitude * table[:, 4] if run.conditions.on == "command" else np.full(len(wanted), np.nan)
    return FrequencyResponse("sweep", run.conditions, wanted, response, table[:, 2], table[:, 3], command)


def _cross(r: Complexes, u: Complexes, y: Complexes, lines_Hz: Floats, centre_Hz: float) -> tuple[float, float, float, float, float]:
    """Response at the centre, its relative deviation, coherence of excitation and position, command over excitation.

    The joint integrates: s·Y is smoother over the lines than Y, so that is averaged.
    """
    rate = y * lines_Hz / centre_Hz
    g = np.vdot(r, rate) / np.vdot(r, u)
    coherence = abs(np.vdot(r, rate)) ** 2 / (np.vdot(r, r).real * np.vdot(rate, rate).real)
    left = rate - g * u
    sigma = np.sqrt(np.vdot(left, left).real / np.vdot(g * u, g * u).real / max(1, len(r) - 1))
    share = abs(np.vdot(r, u)) / np.vdot(r, r).real
    return float(g.real), float(g.imag), float(sigma), float(coherence), float(share)


def _drift(values: Floats) -> Floats:
    """Straight line between the ends."""
    return np.linspace(values[0], values[-1], len(values))


def combined(responses: list[FrequencyResponse]) -> FrequencyResponse:
    """Mean over realisations of the phases at the same conditions: the best linear approximation. Its `sigma` comes from their
    scatter, which holds noise and the nonlinear part that changes with the phases. All have the same frequencies."""
    first = responses[0]
    assert all(np.array_equal(each.frequencies_Hz, first.frequencies_Hz) for each in responses)
    if len(responses) == 1:
        return first
    table = np.array([each.response for each in responses])
    mean = np.mean(table, axis=0)
    sigma = np.std(table, axis=0, ddof=1) / np.abs(mean) / np.sqrt(len(table))
    coherence = np.mean([each.coherence for each in responses], axis=0)
    odd, even = (_combined([getattr(each, name) for each in responses]) for name in ("odd", "even"))
    command = np.mean([each.command_V for each in responses], axis=0)
    return FrequencyResponse(first.source, first.conditions, first.frequencies_Hz, mean, sigma, coherence, command, odd, even)


def _combined(parts: list[Distortion | None]) -> Distortion | None:
    """Mean power of the levels."""
    known = [part for part in parts if part is not None]
    if not known:
        return None
    levels = (
        10.0 * np.log10(np.mean([10.0 ** (getattr(part, name) / 10.0) for part in known], axis=0)) for name in ("level_dB", "noise_dB")
    )
    return Distortion(known[0].frequencies_Hz, *levels)
