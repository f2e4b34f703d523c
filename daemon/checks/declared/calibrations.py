"""How long the calibrations still hold: days left of every signal whose calibration ends, renewed once a second."""

from __future__ import annotations

import datetime
from collections.abc import Iterator
from math import inf

from config.schema.rig import Rig
from daemon.checks.checks import Reaction
from daemon.checks.declaration import Declaration, DeclaredFact, Family, Stage, Subject
from daemon.cycle.facts import Facts

PERIOD_NS = 1_000_000_000
DAY_NS = 86_400 * 10**9
_REACTIONS = {"warn": Reaction.WARN, "block": Reaction.REFUSE}
_FACT = "{signal}.calibration_days_left"


def _that_end(rig: Rig) -> Iterator[Subject]:
    for name, signal in rig.signals.items():
        calibration = signal.calibration
        if calibration.valid_until:
            by = f", by {calibration.by}" if calibration.by else ""
            calibrated = f"calibrated {calibration.calibrated_on or 'on an unknown day'}{by}"
            yield {"signal": name, "calibrated": calibrated, "valid_until": str(calibration.valid_until)}


class CalibrationWatch:
    """The last day of a calibration counts to its end, in UTC. The time is that of the log."""

    def __init__(self, rig: Rig, facts: Facts) -> None:
        signals = [subject["signal"] for subject in _that_end(rig)]
        self._ends = [(facts.index(_FACT.format(signal=name)), _end_ns(rig.signals[name].calibration.valid_until)) for name in signals]
        self._next_ns = 0

    def update(self, values: list[float], now_ns: int, unix_ns: int) -> None:
        if now_ns < self._next_ns:
            return
        self._next_ns = now_ns + PERIOD_NS
        for index, end_ns in self._ends:
            values[index] = (end_ns - unix_ns) / DAY_NS


def _end_ns(last_day: datetime.date | None) -> int:
    """Unix ns of the end of a day; never, where there is none."""
    if last_day is None:
        return 1 << 62
    return (last_day.toordinal() + 1 - datetime.date(1970, 1, 1).toordinal()) * DAY_NS


CALIBRATION = Declaration(
    name="{signal} calibration",
    fact=_FACT,
    meaning="days until the end of `signals.NAME.calibration.valid_until` (UTC)",
    unit="days left",
    limits=lambda rig, subject: (0, inf),
    limit_from="not over; asked where `signals.NAME.calibration.valid_until` is given",
    source="{calibrated}",
    reaction=lambda rig, subject: _REACTIONS[rig.signals[subject["signal"]].calibration.on_expiry],
    reaction_from="that of `signals.NAME.calibration.on_expiry`: `warn` warns and arms, `block` refuses arming",
    advice="It was valid until {valid_until}: calibrate again, write the new record into signals.{signal}.calibration, "
    "and `longreach check` the rig file.",
)

FAMILIES = (
    Family(
        "Calibrations that end",
        Stage.CALIBRATION,
        _that_end,
        (CALIBRATION,),
        (DeclaredFact(_FACT),),
        watch=CalibrationWatch,
        spare=True,
        from_log=True,
    ),
)
