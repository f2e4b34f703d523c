"""How much the tip still swings: the rms of its acceleration about its mean, so that a run can be made to start from rest.

Without a sensor at the tip nobody knows; then there is no such number and no such check.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import exp, inf, isfinite, nan, sqrt

from config.rig import Rig
from daemon.checks import Check, Reaction
from daemon.facts import SWING_FACT, Facts
from recording.fields import field_of_signal

SENSOR = "tip.acceleration"
MEAN_S = 2.0  # the sensor's bias is no swing
RMS_S = 0.5  # a period of the link or more
_ADVICE = "Wait, give a longer `--settle`, or use a command filter before; `--settle 0` starts in spite of it."


def start_checks(rig: Rig, facts: Facts) -> tuple[Check, ...]:
    """What a run waits for that shall start from rest."""
    if SENSOR not in rig.signals:
        return ()
    signal = rig.signals[SENSOR]
    source, most = f"{signal.device}.{signal.channel}", rig.interlocks.start_swing_max_m_per_s2
    return (Check("tip at rest", facts.index(SWING_FACT), -inf, most, "m/s^2 rms", source, Reaction.REFUSE, _ADVICE),)


def not_at_rest(checks: tuple[Check, ...], values: tuple[float, ...]) -> Iterator[str]:
    """What still moves, in sentences."""
    return (check.sentence(values) for check in checks if not check.passes(values))


class Swing:
    """`update` once a cycle: two means that forget, of the acceleration and of its square about the first."""

    def __init__(self, rig: Rig, facts: Facts) -> None:
        self._is_measured = SENSOR in rig.signals
        if self._is_measured:
            self._at_acceleration, self._at_swing = facts.index(field_of_signal(SENSOR)), facts.index(SWING_FACT)
        period_s = 1.0 / rig.loop.rate_Hz
        self._forget_mean, self._forget_square = 1.0 - exp(-period_s / MEAN_S), 1.0 - exp(-period_s / RMS_S)
        self._mean, self._square = nan, 0.0

    def update(self, values: list[float]) -> None:
        """A BAD sample changes nothing."""
        if not self._is_measured or not isfinite(acceleration := values[self._at_acceleration]):
            return
        if self._mean != self._mean:
            self._mean = acceleration
        self._mean += self._forget_mean * (acceleration - self._mean)
        self._square += self._forget_square * ((acceleration - self._mean) ** 2 - self._square)
        values[self._at_swing] = sqrt(self._square)
