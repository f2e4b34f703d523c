"""How much the tip still vibrates: the rms of its acceleration about its mean, so that a run can be made to start from rest.

Without a sensor at the tip nobody knows; then there is no such number and no such check.
"""

from __future__ import annotations

from math import exp, inf, isfinite, nan, sqrt

from config.schema.rig import Rig
from daemon.checks.checks import Reaction
from daemon.checks.declaration import Declaration, DeclaredFact, Family, Purpose, Stage, measured
from daemon.cycle.facts import Facts
from recording.format.fields import field_of_signal

SENSOR = "tip.acceleration"
RMS_FACT = "tip.vibration_mps2"
MEAN_S = 2.0  # the sensor's bias is no vibration
RMS_S = 0.5  # a period of the link or more


class TipVibrationWatch:
    """Two means that forget exponentially: of the acceleration, and of its square about the first."""

    def __init__(self, rig: Rig, facts: Facts) -> None:
        self._at_acceleration, self._at_rms = facts.index(field_of_signal(SENSOR)), facts.index(RMS_FACT)
        period_s = 1.0 / rig.loop.rate_Hz
        self._forget_mean, self._forget_square = 1.0 - exp(-period_s / MEAN_S), 1.0 - exp(-period_s / RMS_S)
        self._mean, self._square = nan, 0.0

    def update(self, values: list[float], now_ns: int, unix_ns: int) -> None:
        """While nothing is measured nobody knows; the means stay as they are."""
        acceleration = values[self._at_acceleration]
        if not isfinite(acceleration):
            values[self._at_rms] = nan
            return
        if self._mean != self._mean:
            self._mean = acceleration
        self._mean += self._forget_mean * (acceleration - self._mean)
        self._square += self._forget_square * ((acceleration - self._mean) ** 2 - self._square)
        values[self._at_rms] = sqrt(self._square)


AT_REST = Declaration(
    name="tip at rest",
    fact=RMS_FACT,
    meaning=f"rms of the tip's acceleration about its mean, over about {RMS_S:g} s",
    unit="m/s^2 rms",
    limits=lambda rig, subject: (-inf, rig.interlocks.start_swing_max_m_per_s2),
    limit_from="at most `interlocks.start_swing_max`",
    source="{source}",
    reaction=Reaction.REFUSE,
    advice="Wait, give a longer `--settle`, or use a command filter before; `--settle 0` starts in spite of it.",
    purposes=(Purpose.REST,),
)

FAMILIES = (
    Family(
        "At a start that waits for rest",
        Stage.REST,
        lambda rig: measured(rig, SENSOR),
        (AT_REST,),
        facts=(DeclaredFact(RMS_FACT),),
        watch=TipVibrationWatch,
        spare=True,
    ),
)
