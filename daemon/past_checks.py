"""The checks at a moment of a log, from its columns alone: the same objects as in the loop, walked through the rows before that moment.

Facts that no column holds (recorder, disk, supervisor, a latched e-stop) cannot be asked afterwards; their checks say so. What the loop did
about a failed check stands in the log's events.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, pairwise
from math import isnan
from typing import Any

import numpy as np

from config.errors import LogError
from config.rig import Rig
from control.signals import Mode
from daemon.facts import Facts
from daemon.interlocks import interlocks
from daemon.plausibility import Plausibility
from drivers.contract import Quality
from recording.event import Event, Level
from recording.fields import field_of_signal
from recording.layout import CycleLayout
from recording.reader import Log, open_rig

MEMORY_S = 2.0  # longer than any plausibility rule remembers
LATER_FIELDS = ("mode", "target", "target_rate", "reference", "reference_rate", "velocity", "command_V")  # set after the checks of a cycle


@dataclass(frozen=True, slots=True)
class Moment:
    """What was known in the cycle at `t_s`. `checks` as `longreach why` shows them, with `ok` None where the log does not tell."""

    t_s: float
    cycle: int
    mode: Mode
    checks: list[dict[str, Any]]
    events: list[Event]


def checks_at(log: Log, t_s: float | None) -> Moment:
    """The last cycle not after `t_s` (seconds as in the log's column; None: the last one).

    LogError for a time outside the log and for a log without a rig file.
    """
    rig = open_rig(log)
    end = _row_at(log, t_s)
    facts = Facts(rig, CycleLayout.of_rig(rig))
    values = _walk(log, rig, facts, end)
    known = _known(log, rig, facts)
    rows = [_asked(check.row(values), check.index in known) for check in interlocks(rig, facts)]
    cycle = int(log.columns["cycle"][end])
    before = [event for event in log.events if event.cycle <= cycle and event.level >= Level.WARNING]
    return Moment(float(log.columns["t_s"][end]), cycle, Mode(int(log.columns["mode"][end])), rows, before[-5:])


def _row_at(log: Log, t_s: float | None) -> int:
    times = log.columns["t_s"]
    if not len(times):
        raise LogError("the log holds no cycle", where=str(log.path), next_step="Run `longreach log check`.")
    if t_s is None:
        return len(times) - 1
    if not times[0] <= t_s <= times[-1]:
        limit = f"{times[0]:.3f} to {times[-1]:.3f} s"
        advice = "Times are those of the column t_s; `longreach log info` shows the range."
        raise LogError("the moment is outside the log", value=f"{t_s:g} s", limit=limit, where=str(log.path), next_step=advice)
    return int(np.searchsorted(times, t_s, side="right")) - 1


def _walk(log: Log, rig: Rig, facts: Facts, end: int) -> list[float]:
    """The facts as the loop had them when it checked row `end`: what the controller computes is still that of the cycle before."""
    plausibility, values = Plausibility(rig, facts), facts.blank()
    errors = {facts.index(f"{j}.following_error"): (facts.index(f"{j}.reference"), facts.index(f"{j}.position")) for j in rig.joints}
    later = _places(facts, rig)
    rows = _rows(log, facts, max(0, end - round(MEMORY_S * rig.loop.rate_Hz)), end)
    for before, row in pairwise(chain([tuple(values)], rows)):
        values[: facts.row_length] = row
        for index in later:
            values[index] = before[index]
        for index, (reference, position) in errors.items():
            values[index] = abs(before[reference] - before[position])
        _qualities(rig, facts, values)
        plausibility.update(values, round(1e9 * values[facts.index("t_s")]))
    return values


def _rows(log: Log, facts: Facts, start: int, end: int) -> Iterator[tuple[float, ...]]:
    """Rows as the loop's facts have them; a column that an older log lacks is NaN."""
    missing = np.full(len(log.time_ns), np.nan)
    columns = [log.columns.get(name, missing)[start : end + 1].tolist() for name in facts.names[: facts.row_length]]
    return zip(*columns, strict=True)


def _places(facts: Facts, rig: Rig) -> tuple[int, ...]:
    return (facts.index("mode"), *(facts.index(f"{joint}.{name}") for joint in rig.joints for name in LATER_FIELDS[1:]))


def _qualities(rig: Rig, facts: Facts, values: list[float]) -> None:
    """The log has no quality, but a BAD sample is written as NaN."""
    for name in rig.signals:
        lost = isnan(values[facts.index(field_of_signal(name))])
        values[facts.index(f"{name}.quality")] = float(Quality.BAD if lost else Quality.GOOD)


def _known(log: Log, rig: Rig, facts: Facts) -> set[int]:
    """Places of the facts that the columns give, directly or by the same arithmetic as in the loop."""
    first_of_rest = facts.index("estop_latched")
    columns = {facts.index(name) for name in facts.names[: facts.row_length] if name in log.columns}
    return columns | set(range(facts.row_length, first_of_rest))


def _asked(row: dict[str, Any], known: bool) -> dict[str, Any]:
    return row if known else {**row, "ok": None, "value": None, "age_s": None}
