"""One number over the weeks: every log with its interval, the line through them, the limits."""

from __future__ import annotations

import math
from datetime import timedelta
from typing import Any

import numpy as np
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter
from matplotlib.figure import Figure

from gap.outcome.file_units import Shown
from gap.report.inline_picture import inline
from gap.report.plots import AFTER, BEFORE, FLOOR_COLOUR
from gap.watch.followed import Followed

_POINTS = 200


def over_time(one: Followed, shown: Shown) -> str:
    """An inline picture; of a number with a course."""
    assert one.course is not None
    figure = Figure(figsize=(8.0, 2.6), layout="constrained")
    axes = figure.subplots()
    begun: Any = [log.begun for log in one.logs]
    values = np.array([v.value for v in one.values])
    widths = 1.96 * np.array([v.sd for v in one.values])
    axes.errorbar(begun, shown.of(values), abs(shown.factor) * widths, fmt="o", color="black", markersize=3, linewidth=1, capsize=2)
    _line(axes, one, shown)
    axes.axhline(shown.of(one.number.free.start), color=FLOOR_COLOUR, linestyle=":", linewidth=1, label="rig file")
    near = [limit for limit in (one.limits.low, one.limits.high) if math.isfinite(limit) and _near(limit, values, widths)]
    for k, limit in enumerate(near):
        axes.axhline(shown.of(limit), color=BEFORE, linestyle="--", linewidth=1, label=None if k else "limit")
    axes.set_ylabel(f"{one.number.name.rpartition('.')[2]} ({shown.unit})".removesuffix(" ()"), fontsize=8)
    axes.set_title(one.number.name, fontsize=9)
    locator = AutoDateLocator()
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(ConciseDateFormatter(locator))
    axes.tick_params(labelsize=7)
    axes.legend(fontsize=7, loc="best")
    return inline(figure, f"{one.number.name} in {len(begun)} logs: {one.word}")


def _near(limit: float, values: np.ndarray, widths: np.ndarray) -> bool:
    """Whether the picture still shows the logs when it shows the limit as well."""
    low, high = float(np.min(values - widths)), float(np.max(values + widths))
    return low - 3 * (high - low) <= limit <= high + 3 * (high - low)


def _line(axes: Any, one: Followed, shown: Shown) -> None:
    """The course with the 95 % band of its line, piece by piece."""
    course = one.course
    assert course is not None
    begun, days = one.logs[0].begun, course.pieces.days
    for piece in range(len(course.steps) + 1):
        first, last = course.pieces.ends(piece)
        at = np.linspace(days[first], days[last - 1], _POINTS)
        middle, sd = np.array([course.fit.at(course.pieces.row(piece, float(day))) for day in at]).T
        band = course.fit.times_sd() * sd
        moments: Any = [begun + timedelta(days=float(day)) for day in at]
        axes.plot(moments, shown.of(middle), color=AFTER, linewidth=1.2, label=None if piece else one.word)
        axes.fill_between(moments, shown.of(middle - band), shown.of(middle + band), color=AFTER, alpha=0.2, linewidth=0)
