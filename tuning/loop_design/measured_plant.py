"""A joint's measured response as a member of a design's family: of sine tests on the simulated rig, or of an identification's waves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from config.schema.rig import Rig
from tuning.arrays import Complexes, Floats
from tuning.responses.frequency_response import FrequencyResponse

HALF_HOLD = 0.5  # cycles: every other delay is in a response that was measured through the loop
MOST_SIGMA = 0.1  # relative standard deviation of a line
FEWEST_LINES = 8
LAST_OCTAVE = 2.0  # its lines tell together, with less noise than the last two, how the response goes on


@dataclass(frozen=True, eq=False)
class MeasuredPlant:
    """Position per volt (rad or m per V) from velocity responses at `tested_Hz`, between them on straight lines of log gain and phase over
    log f. Beyond the last one it goes on falling as in the last octave, the phase over f as behind a dead time: a joint that is measured
    to where it lags by 150 degrees limits the gain as well, and rather a little too much."""

    amplitude_V: float
    tested_Hz: Floats
    log_gain: Floats
    phase: Floats
    delay_s: float

    def __call__(self, omega: Floats) -> Complexes:
        """At frequencies in rad/s. Below the first one the joint is a pure integrator of the first gain."""
        place, tested = np.log(omega), np.log(2.0 * np.pi * self.tested_Hz)
        fall, lag_s = self._beyond
        log_gain = np.interp(place, tested, self.log_gain) - fall * np.maximum(place - tested[-1], 0.0)
        phase = np.interp(place, tested, self.phase) - lag_s * np.maximum(omega - 2.0 * np.pi * self.tested_Hz[-1], 0.0)
        return np.asarray(np.exp(log_gain + 1j * phase) / (1j * omega) * np.exp(-1j * omega * self.delay_s))

    @cached_property
    def _beyond(self) -> tuple[float, float]:
        """How the last octave falls: decades of gain per decade, and radians of phase per rad/s; at least 0."""
        last = self.tested_Hz >= self.tested_Hz[-1] / LAST_OCTAVE
        omega = 2.0 * np.pi * self.tested_Hz[last]
        slopes = [np.polyfit(over, values[last], 1)[0] for over, values in ((np.log(omega), self.log_gain), (omega, self.phase))]
        return max(0.0, -float(slopes[0])), max(0.0, -float(slopes[1]))


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
