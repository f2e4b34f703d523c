"""Frequency response, noise and distortion from an odd random-phase multisine (R. Pintelon and J. Schoukens, System
Identification: A Frequency Domain Approach, 2012, chapters 3 and 4).

Whole periods are transformed without leakage. Their mean is the response, their scatter the noise. What stands at odd lines that were
not excited is odd nonlinearity, at even lines even nonlinearity; G·U is taken off there, because the servo reacts to its own output.
"""

from __future__ import annotations

import numpy as np

from config.errors import LogError
from servo_control.path.multisine import odd_harmonics
from tuning.arrays import Complexes, Floats
from tuning.experiments.excited_run import ExcitedRun
from tuning.responses.frequency_response import Distortion, FrequencyResponse, without_hold

TRANSIENT_PERIODS = 1  # left out at the beginning
FEWEST_PERIODS = 2


def multisine_response(run: ExcitedRun) -> FrequencyResponse:
    """LogError when a period is no whole number of cycles, or there are fewer than three of them."""
    period_s, content = float(run.maneuver["period"]), run.maneuver
    u, y = (_periods(run, values) for values in (run.command, run.position))
    excited = np.array(odd_harmonics(content["from"], content["to"], period_s, int(content["lines"])))
    u_mean, y_mean = np.mean(u, axis=0), np.mean(y, axis=0)
    response = y_mean[excited] / u_mean[excited]
    sigma = _sigma(u[:, excited] / u_mean[excited], y[:, excited] / y_mean[excited])
    coherence = np.abs(np.mean(y[:, excited] * np.conj(u[:, excited]), axis=0)) ** 2 / (
        np.mean(np.abs(y[:, excited]) ** 2, axis=0) * np.mean(np.abs(u[:, excited]) ** 2, axis=0)
    )
    inside = np.arange(excited[0], excited[-1] + 1)
    silent = inside[~np.isin(inside, excited)]
    odd, even = (_distortion(u, y, excited, response, silent[silent % 2 == parity], period_s) for parity in (1, 0))
    frequencies = excited / period_s
    response = without_hold(frequencies, response, run.period_s)
    return FrequencyResponse("multisine", run.conditions, frequencies, response, sigma, coherence, np.abs(u_mean[excited]), odd, even)


def _periods(run: ExcitedRun, values: Floats) -> Complexes:
    """Transforms of every used period, (periods, lines); a straight drift over all of them is taken off first."""
    rows = float(run.maneuver["period"]) / run.period_s
    count, first = int(run.maneuver["periods"]), round(float(run.maneuver["fade"]) / run.period_s)
    if abs(rows - round(rows)) > 1e-6 or count - TRANSIENT_PERIODS < FEWEST_PERIODS:
        raise LogError(
            "the multisine cannot be averaged over whole periods",
            value=f"{count} periods of {rows:.3f} cycles",
            limit=f"at least {FEWEST_PERIODS + TRANSIENT_PERIODS} periods of a whole number of cycles",
            where=f"run {run.run}",
        )
    whole = round(rows)
    start = first + TRANSIENT_PERIODS * whole
    table = values[start : start + (count - TRANSIENT_PERIODS) * whole].reshape(-1, whole)
    slope = float(np.mean(np.diff(table, axis=0))) / whole  # from period to period, where the signal itself is the same
    table = table - slope * np.arange(table.size).reshape(-1, whole)
    return np.asarray(2.0 * np.fft.rfft(table, axis=1) / whole, dtype=np.complex128)


def _sigma(u: Complexes, y: Complexes) -> Floats:
    """Relative standard deviation of mean(Y)/mean(U), both given relative to their means."""
    return np.asarray(np.std(y - u, axis=0, ddof=1) / np.sqrt(len(u)), dtype=np.float64)


def _distortion(u: Complexes, y: Complexes, excited: Floats, response: Complexes, lines: Floats, period_s: float) -> Distortion:
    unwrapped = np.unwrap(np.angle(response))
    g = np.exp(np.interp(lines, excited, np.log(np.abs(response))) + 1j * np.interp(lines, excited, unwrapped))
    own = y[:, lines] - g * u[:, lines]
    beside = np.exp(np.interp(lines, excited, np.log(np.abs(np.mean(y[:, excited], axis=0)))))
    noise = np.std(own, axis=0, ddof=1) / np.sqrt(len(own))
    return Distortion(lines / period_s, *(20.0 * np.log10(level / beside) for level in (np.abs(np.mean(own, axis=0)), noise)))
