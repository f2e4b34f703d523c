"""The checks at a moment of a log, from its columns and set points: the same objects as in the loop, walked through the rows before it.

Facts that no log holds (recorder, disk, supervisor, a latched e-stop) cannot be asked afterwards; their checks say so. What the loop did
about a failed check stands in the log's events.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, pairwise
from math import isnan
from typing import Any

import numpy as np

from config.errors import UsageError
from config.schema.rig import Rig
from daemon.checks.declared.driving_by_hand import FACTS as DRIVING
from daemon.checks.interlocks import facts_from_log, interlocks, rig_facts, watches
from daemon.checks.past_driving import driving_before, driving_is_known
from daemon.cycle.facts import Facts
from drivers.contract import Quality
from recording.files.info import require_cycles
from recording.files.reader import Log, open_rig
from recording.files.recordings import asked
from recording.format.event import Event, Level
from recording.format.fields import field_of_signal
from servo_control.signals import NOT_DRIVEN, Mode

MEMORY_S = 2.0  # longer than any plausibility rule remembers
LATER_FIELDS = ("mode", "target", "target_rate", "reference", "reference_rate", "velocity", "command_V")  # set after the checks of a cycle


@dataclass(frozen=True, slots=True)
class Moment:
    """What was known in the cycle at `t_s`. `checks` as `longreach why` shows them, with `ok` None where the log has no such number."""

    t_s: float
    cycle: int
    mode: Mode
    checks: list[dict[str, Any]]
    events: list[Event]


def checks_at(log: Log, t_s: float | None) -> Moment:
    """The cycle nearest to `t_s` (seconds as in the log's column; None: the last one): times are shown to the millisecond.

    UsageError for a time outside the log, LogError for a log without a rig file.
    """
    rig = open_rig(log)
    end = _row_at(log, t_s)
    facts = rig_facts(rig)
    start = max(0, end - round(MEMORY_S * rig.loop.rate_Hz))
    (values,) = deque(walked(log, rig, facts, start, end), maxlen=1)
    known = known_facts(log, rig, facts)
    rows = [_as_known(check.row(values), check.index in known) for check in interlocks(rig, facts)]
    cycle = int(log.columns["cycle"][end])
    before = [event for event in log.events if event.cycle <= cycle and event.level >= Level.WARNING]
    return Moment(float(log.columns["t_s"][end]), cycle, Mode(int(log.columns["mode"][end])), rows, before[-5:])


def _row_at(log: Log, t_s: float | None) -> int:
    require_cycles(log)
    times = log.columns["t_s"]
    if t_s is None:
        return len(times) - 1
    if not times[0] <= t_s <= times[-1]:
        limit = f"{times[0]:.3f} to {times[-1]:.3f} s"
        advice = f"Times are those of the column t_s; {asked('info', log.path)} shows the range."
        raise UsageError("the moment is outside the log", value=f"{t_s:g} s", limit=limit, where=str(log.path), next_step=advice)
    return int(np.argmin(np.abs(times - t_s)))


def walked(log: Log, rig: Rig, facts: Facts, start: int, end: int) -> Iterator[list[float]]:
    """For every row from `start` to `end` the facts as the loop had them when it checked it: what the controller computes is still that of
    the cycle before. The same list every time; rules that remember know nothing from before `start`."""
    watching, values = watches(rig, facts, lambda family: family.from_log), facts.blank()
    errors = {facts.index(f"{j}.following_error"): (facts.index(f"{j}.reference"), facts.index(f"{j}.position")) for j in rig.joints}
    later, at_t, at_driving = _set_after_checks(facts, rig), facts.index("t_s"), [facts.index(name) for name in DRIVING]
    rows = zip(_rows(log, facts, start, end), log.time_ns[start : end + 1].tolist(), driving_before(log, rig, start, end), strict=True)
    for (before, _, _), (row, unix_ns, driving) in pairwise(chain([(tuple(values), 0, NOT_DRIVEN)], rows)):
        values[: facts.row_length] = row
        for index, fact in zip(at_driving, driving, strict=True):
            values[index] = fact
        for index in later:
            values[index] = before[index]
        for index, (reference, position) in errors.items():
            values[index] = abs(before[reference] - before[position])
        _qualities(rig, facts, values)
        for watch in watching:
            watch.update(values, round(1e9 * values[at_t]), unix_ns)
        yield values


def _rows(log: Log, facts: Facts, start: int, end: int) -> Iterator[tuple[float, ...]]:
    """Rows as the loop's facts have them; a column that an older log lacks is NaN."""
    missing = np.full(len(log.time_ns), np.nan)
    columns = [log.columns.get(name, missing)[start : end + 1].tolist() for name in facts.names[: facts.row_length]]
    return zip(*columns, strict=True)


def _set_after_checks(facts: Facts, rig: Rig) -> tuple[int, ...]:
    """Indices of the columns that a cycle sets only after its checks."""
    return (facts.index("mode"), *(facts.index(f"{joint}.{name}") for joint in rig.joints for name in LATER_FIELDS[1:]))


def _qualities(rig: Rig, facts: Facts, values: list[float]) -> None:
    """The log has no quality, but a BAD sample is written as NaN."""
    for name in rig.signals:
        lost = isnan(values[facts.index(field_of_signal(name))])
        values[facts.index(f"{name}.quality")] = float(Quality.BAD if lost else Quality.GOOD)


def known_facts(log: Log, rig: Rig, facts: Facts) -> set[int]:
    """Indices of the facts that the columns give, directly or by the same arithmetic as in the loop."""
    columns = (name for name in facts.names[: facts.row_length] if name in log.columns)
    computed = (*(f"{signal}.quality" for signal in rig.signals), *(f"{joint}.following_error" for joint in rig.joints))
    driving = DRIVING if driving_is_known(log) else ()
    return {facts.index(name) for name in (*columns, *computed, *facts_from_log(rig), *driving)}


def _as_known(row: dict[str, Any], known: bool) -> dict[str, Any]:
    return row if known else {**row, "ok": None, "value": None, "age_s": None}
