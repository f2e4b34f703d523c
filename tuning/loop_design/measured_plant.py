"""A joint's measured response as a member of a design's family: of sine tests on the simulated rig, or of an identification's waves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from config.schema.rig import Rig
from tuning.arrays import Complexes, Floats
from tuning.responses.frequency_response import FrequencyResponse

DECADES_PER_DECADE = 3.0  # slope beyond the last frequency: two of the load's oscillator and part of the valve's
HALF_HOLD = 0.5  # cycles: every other delay is in a response that was measured through the loop
MOST_SIGMA = 0.1  # relative standard deviation of a line
FEWEST_LINES = 8


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredPlant:
    """Position per volt (rad or m per V) from velocity responses at `tested_Hz`, between them on straight lines of log gain and phase over
    log f."""

    amplitude_V: float
    tested_Hz: Floats
    log_gain: Floats
    phase: Floats
    delay_s: float

    def __call__(self, omega: Floats) -> Complexes:
        """At frequencies in rad/s. Below the first one the joint is a pure integrator of the first gain."""
        place, tested = np.log(omega), np.log(2.0 * np.pi * self.tested_Hz)
        beyond = np.maximum(place - tested[-1], 0.0)
        velocity = np.exp(np.interp(place, tested, self.log_gain) - DECADES_PER_DECADE * beyond + 1j * np.interp(place, tested, self.phase))
        return np.asarray(velocity / (1j * omega) * np.exp(-1j * omega * self.delay_s))


def measured_plants(rig: Rig, responses: Sequence[FrequencyResponse]) -> list[MeasuredPlant]:
    """Responses from command to position; of one where friction holds the joint too few lines are known, and it is left out."""
    found = []
    for response in responses:
        known = response.sigma < MOST_SIGMA
        if response.conditions.on != "command" or np.count_nonzero(known) < FEWEST_LINES:
            continue
        frequencies_Hz = response.frequencies_Hz[known]
        velocity = response.response[known] * 2j * np.pi * frequencies_Hz
        phase = np.unwrap(np.angle(velocity))
        found.append(
            MeasuredPlant(response.conditions.amplitude, frequencies_Hz, np.log(np.abs(velocity)), phase, HALF_HOLD / rig.loop.rate_Hz)
        )
    return found
