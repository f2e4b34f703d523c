"""Panels of lines under each other over one axis, as a PNG file or as SVG text that stands in a page."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from config.whole_file import whole_file
from recording.evaluation.chosen_signals import ChosenSignal

WIDTH_IN, PANEL_IN, HEAD_IN = 10.0, 2.1, 0.6
POINTS = 1600  # a line of a page; more cannot be seen and makes the page heavy
_DOTS_PER_INCH = 110
_STYLE = {"font.size": 11, "axes.titlesize": 11, "legend.fontsize": 9, "lines.linewidth": 1.2, "axes.grid": True, "grid.alpha": 0.3}
_COLOURS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf", "#8c564b", "#777777")

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Line:
    label: str
    x: Floats
    y: Floats
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class Panel:
    """`bands`: spans of x that are shaded. `marks`: x of vertical lines. `log_y`: the y axis is logarithmic."""

    title: str
    unit: str
    lines: tuple[Line, ...]
    bands: tuple[tuple[float, float], ...] = ()
    marks: tuple[float, ...] = ()
    log_y: bool = False


def by_unit(signals: Sequence[ChosenSignal], start_s: float = 0.0) -> list[Panel]:
    """One panel for each unit and, of positions and rates, each joint; time counts from `start_s`."""
    groups: dict[tuple[str, str], list[ChosenSignal]] = {}
    for signal in signals:
        owner = signal.name.partition(".")[0] if re.match(r"(deg|rad|m|mm|cm|in|ft|inch)(/s.*)?$", signal.unit) else ""
        groups.setdefault((owner, signal.unit), []).append(signal)
    return [
        Panel(
            ", ".join(label(each.name) for each in members),
            unit,
            tuple(Line(label(each.name), each.t_s - start_s, each.values) for each in members),
        )
        for (_, unit), members in groups.items()
    ]


def label(column: str) -> str:
    """Its name without the SI unit at its end, where a unit beside it says what it is shown in."""
    return re.sub(r"_(Pa|C|V|mps2|m|rad|us|s)$", "", column)


def write_png(panels: Sequence[Panel], title: str, out: str | Path, x_label: str = "time / s") -> None:
    """Under a temporary name first. WriteError when it cannot be written."""
    with rc_context(_STYLE), whole_file(Path(out), "picture") as temporary:
        figure = _drawn(panels, title, x_label)
        FigureCanvasAgg(figure)
        figure.savefig(temporary, dpi=_DOTS_PER_INCH, format="png")


def svg(panels: Sequence[Panel], alternative: str, x_label: str = "time / s") -> str:
    """An <svg> element as wide as its page, with `alternative` for those who cannot see it."""
    thin = [_thinned(panel) for panel in panels]
    with rc_context({**_STYLE, "svg.fonttype": "none", "svg.hashsalt": alternative}):
        figure = _drawn(thin, "", x_label)
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None})
    body = text.getvalue().partition("<svg ")[2]
    body = re.sub(r'width="[^"]*" height="[^"]*"|height="[^"]*" width="[^"]*"', "", body, count=1)
    return f'<svg role="img" aria-label="{_attribute(alternative)}" class="plot" {body}'


def envelope(x: Floats, y: Floats, points: int = POINTS) -> tuple[Floats, Floats]:
    """At most about `points` points that look like all of them: lowest and highest of every stretch, in their order."""
    if len(x) <= points:
        return x, y
    stretches = np.array_split(np.arange(len(x)), points // 2)
    rows: list[int] = []
    for stretch in stretches:
        values = y[stretch]
        if not np.any(np.isfinite(values)):
            rows.append(int(stretch[0]))
            continue
        rows += sorted({int(stretch[np.nanargmin(values)]), int(stretch[np.nanargmax(values)])})
    return x[rows], y[rows]


def _thinned(panel: Panel) -> Panel:
    lines = tuple(Line(line.label, *envelope(line.x, line.y), line.dashed) for line in panel.lines)
    return Panel(panel.title, panel.unit, lines, panel.bands, panel.marks, panel.log_y)


def _drawn(panels: Sequence[Panel], title: str, x_label: str) -> Figure:
    height = HEAD_IN * bool(title) + PANEL_IN * len(panels) + 0.3
    figure = Figure(figsize=(WIDTH_IN, height), layout="constrained")
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axis, panel in zip(axes, panels, strict=True):
        _draw(axis, panel)
    axes[-1].set_xlabel(x_label)
    if title:
        figure.suptitle(title)
    return figure


def _draw(axis: Axes, panel: Panel) -> None:
    for line, colour in zip(panel.lines, cycle(_COLOURS), strict=False):
        axis.plot(line.x, line.y, "--" if line.dashed else "-", color=colour, label=line.label)
    for first, last in panel.bands:
        axis.axvspan(first, last, color="#888888", alpha=0.15, linewidth=0)
    for mark in panel.marks:
        axis.axvline(mark, color="#d62728", linewidth=1.0)
    if panel.log_y and any(np.any(line.y > 0.0) for line in panel.lines):
        axis.set_yscale("log")
    axis.set_ylabel(panel.unit)
    if len(panel.lines) > 1:
        axis.set_title(panel.title if len(panel.title) < 60 else "", loc="left")
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    else:
        axis.set_title(panel.title, loc="left")


def _attribute(text: str) -> str:
    return text.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
