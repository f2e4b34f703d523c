"""How long the calibrations still hold: days left of every signal that has a date, renewed once a second, and their checks."""

from __future__ import annotations

import datetime
from collections.abc import Iterator
from math import inf

from config.rig import Rig
from daemon.checks import Check, Reaction
from daemon.facts import Facts, calibration_facts
from daemon.log_stream import LogStream

PERIOD_NS = 1_000_000_000
DAY_NS = 86_400 * 10**9
_REACTIONS = {"warn": Reaction.WARN, "block": Reaction.REFUSE}


def calibration_checks(rig: Rig, facts: Facts) -> Iterator[Check]:
    """One for every signal whose calibration ends; what an expired one does stands in the rig file."""
    for name, fact in calibration_facts(rig).items():
        calibration = rig.signals[name].calibration
        by = f", by {calibration.by}" if calibration.by else ""
        advice = f"It was valid until {calibration.valid_until}: calibrate again, and write the new record into signals.{name}.calibration."
        source = f"calibrated {calibration.calibrated_on or 'on an unknown day'}{by}"
        yield Check(f"{name} calibration", facts.index(fact), 0, inf, "days left", source, _REACTIONS[calibration.on_expiry], advice)


class CalibrationWatch:
    """The last day of a calibration counts to its end, in UTC. The time is that of the log."""

    def __init__(self, rig: Rig, facts: Facts, log: LogStream) -> None:
        ending = {name: facts.index(fact) for name, fact in calibration_facts(rig).items()}
        self._ends = [(index, _end_ns(rig.signals[name].calibration.valid_until)) for name, index in ending.items()]
        self._log = log
        self._next_ns = 0

    def update(self, values: list[float], now_ns: int) -> None:
        if now_ns < self._next_ns:
            return
        self._next_ns = now_ns + PERIOD_NS
        for index, end_ns in self._ends:
            values[index] = (end_ns - self._log.now_ns) / DAY_NS


def _end_ns(last_day: datetime.date | None) -> int:
    """Unix ns of the end of a day; never, where there is none."""
    if last_day is None:
        return 1 << 62
    return (last_day.toordinal() + 1 - datetime.date(1970, 1, 1).toordinal()) * DAY_NS
