"""A single hydraulic axis fitted to its measured response: Eq 4's form for load and oil, behind its valve's second-order lag.

On an axis the valve is often no faster than load on oil, so the response is measured beyond both, and both are fitted. Nothing is taken
from the rig file: the frequency at which the response lags by 180 degrees gives the guess. A valve is well damped, load on oil is not,
which tells the pairs apart. What the buses delay comes out as part of the valve.
"""

from __future__ import annotations

from math import log, pi

import numpy as np

from tuning.arrays import Floats
from tuning.responses.frequency_response import FrequencyResponse
from tuning.responses.response_fit import (
    NAMES,
    VALVE_NAMES,
    JointFit,
    Lines,
    believed_lines,
    best_fit,
    enough_lines,
    lags_half_a_turn,
    with_valve,
)

STARTS = ((1.3, 0.8), (1.1, 1.5), (1.0, 5.0))  # load and valve, over the frequency of 180 degrees
LOAD_DAMPING, VALVE_DAMPING = 0.1, 0.8  # of the guess
SPAN = 10.0  # either way for gain and frequencies
DAMPING, OF_A_VALVE = (0.002, 3.0), (0.3, 3.0)


def fit_axis(response: FrequencyResponse) -> JointFit:
    """Least squares on the logarithm from several guesses. LogError for fewer lines than parameters."""
    lines = believed_lines(response)
    names = (*NAMES, *VALVE_NAMES)
    enough_lines(lines, len(names), response)
    guesses = [_guess(lines, load, valve) for load, valve in STARTS]
    return best_fit(lines, names, with_valve, [(guess, _limits(guess)) for guess in guesses])


def _guess(lines: Lines, load: float, valve: float) -> Floats:
    omega = lags_half_a_turn(lines)
    velocity_gain = float(np.median((np.abs(lines.measured) * lines.omega)[: max(3, len(lines.omega) // 4)]))
    square = (load * omega) ** 2
    return np.log([velocity_gain * square, 2.0 * LOAD_DAMPING * load * omega, square, valve * omega / (2.0 * pi), VALVE_DAMPING])


def _limits(guess: Floats) -> tuple[Floats, Floats]:
    """Of the logarithms; the damping of the load is that of Eq 4, 2 ζ ω."""
    wide, load = log(SPAN), 0.5 * guess[2]
    (low, high), (valve_low, valve_high) = np.log(DAMPING), np.log(OF_A_VALVE)
    lower = [guess[0] - 3.0 * wide, log(2.0) + load + low, guess[2] - 2.0 * wide, guess[3] - wide, valve_low]
    upper = [guess[0] + 3.0 * wide, log(2.0) + load + high, guess[2] + 2.0 * wide, guess[3] + 2.0 * wide, valve_high]
    return np.array(lower), np.array(upper)
