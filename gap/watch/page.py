"""watch.html: alarms and numbers first, then each number over the weeks, then the logs and those that could not be used."""

from __future__ import annotations

from collections.abc import Sequence

from config.loading.load import LoadedRig
from config.readable import number
from gap.outcome.file_units import FileUnits, Shown
from gap.watch.dated_logs import DatedLog, Unusable
from gap.watch.followed import Followed
from gap.watch.log_fit import LogFit
from gap.watch.plots import over_time
from recording.evaluation.page import page, paragraph, table, verdict

EXPLAINED = 1.5  # noise floors up to which a log counts as explained by its numbers
HEAD = ["number", "rig file", "now (95 %)", "change a week (95 %)", "steps", "limits", ""]


def watch_page(
    loaded: LoadedRig, numbers: Sequence[Followed], fits: Sequence[tuple[DatedLog, LogFit]], unusable: Sequence[Unusable]
) -> str:
    units = FileUnits(loaded.text)
    told = [one for one in numbers if one.course is not None]
    shown = {one.number.name: units.constant(one.number.free.key, one.number.free.unit) for one in numbers}
    first = [f"<h1>{loaded.rig.name}</h1>", verdict(not any(one.alarm for one in told), *headline(numbers, fits))]
    rows = [row(one, shown[one.number.name]) for one in told]
    first.append(table(HEAD, rows, [one.alarm for one in told]) if rows else "")
    pictures = [over_time(one, shown[one.number.name]) for one in told]
    parts = [f'<section class="first">{"".join(first)}</section>', _unknown(numbers), *pictures, _logs(fits), _unusable(unusable)]
    return page(f"{loaded.rig.name}: wear", parts)


def headline(numbers: Sequence[Followed], fits: Sequence[tuple[DatedLog, LogFit]]) -> tuple[str, str]:
    """What a reader wants first: the alarms, else that there are none; and from how many logs."""
    span = f"{len(fits)} logs from {fits[0][0].begun:%Y-%m-%d} to {fits[-1][0].begun:%Y-%m-%d}"
    alarms = [one.number.name for one in numbers if one.alarm]
    return (f"alarm: {', '.join(alarms)}" if alarms else "no alarm"), f"{span}."


def row(one: Followed, shown: Shown) -> list[str]:
    """One number with a course, in the units of the rig file."""
    assert one.course is not None
    slope, half = one.course.slope
    factor = abs(shown.factor)
    steps = [
        f"{_about(shown.factor * by, factor * about, shown)} at {one.logs[first].path.name} ({one.logs[first].begun:%Y-%m-%d})"
        for first, (by, about) in ((first, one.course.step(k)) for k, first in enumerate(one.course.steps))
    ]
    change = _about(7.0 * shown.factor * slope, 7.0 * factor * half, shown)
    return [one.number.name, shown.text(one.number.free.start), now(one, shown), change, "; ".join(steps), _limits(one, shown), said(one)]


def _about(value: float, half: float, shown: Shown) -> str:
    """A difference, in the unit of the number already."""
    return f"{number(value)} ± {number(half)} {shown.unit}".rstrip()


def now(one: Followed, shown: Shown) -> str:
    """What it is at the last log, with its interval."""
    value, width = one.now
    return f"{shown.text(value)} ({shown.span((value - width, value + width))})"


def said(one: Followed) -> str:
    """What it does, and when it will be too much."""
    ahead = one.limit_in_days
    return ", ".join([*(["ALARM"] if one.alarm else []), one.word, *([f"at its limit in {ahead:.0f} days"] if ahead is not None else [])])


def _limits(one: Followed, shown: Shown) -> str:
    low, high = (number(float(shown.of(value))) if abs(value) < float("inf") else "" for value in (one.limits.low, one.limits.high))
    said = f"{low} to {high}" if low and high else f"at least {low}" if low else f"at most {high}" if high else ""
    return f"{said} {shown.unit}".rstrip() if said else "none"


def _unknown(numbers: Sequence[Followed]) -> str:
    rows = [[one.number.name, one.word, str(len(one.logs))] for one in numbers if one.course is None]
    if not rows:
        return ""
    why = "What these logs do not tell: too few of them have the number, or they know it no better than the rig file does."
    return "<h2>Unknown</h2>" + paragraph(why) + table(["number", "", "logs that tell something"], rows)


def _logs(fits: Sequence[tuple[DatedLog, LogFit]]) -> str:
    rows = [[log.path.name, f"{log.begun:%Y-%m-%d %H:%M}", f"{fit.cost:.3g}"] for log, fit in fits]
    open_ = [fit.cost > EXPLAINED for _, fit in fits]
    advice = f"{sum(open_)} of {len(fits)} logs are not explained (above {EXPLAINED:g} noise floors): `longreach gap find`."
    note = paragraph(advice) if any(open_) else ""
    return "<h2>Logs</h2>" + note + table(["log", "begun (UTC)", "left over (noise floors; 1: nothing but noise)"], rows, open_)


def _unusable(unusable: Sequence[Unusable]) -> str:
    if not unusable:
        return ""
    return "<h2>Not used</h2>" + table(["log", "why", "next"], [[one.path.name, one.why, one.next_step] for one in unusable])
