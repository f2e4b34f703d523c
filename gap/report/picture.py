"""One picture of a whole search: the cost step by step, the most revealing window, and the effect's fingerprint before and after."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from config.whole_file import whole_file
from gap.outcome.file_units import FileUnits
from gap.outcome.found import Found
from gap.report import plots
from gap.report.shown import fingerprints, of_channel, stages, telling_channel


def write_picture(found: Found, path: Path, title: str) -> None:
    """A PNG file."""
    figure, units = Figure(figsize=(10, 7), layout="constrained"), FileUnits(found.rig.text)
    figure.suptitle(title, fontsize=10)
    grid: dict[str, Any] = figure.subplot_mosaic([["costs", "signal"], ["costs", "left"], ["before", "after"]], height_ratios=(1, 1, 1.4))
    plots.draw_costs(grid["costs"], stages(found))
    channel = telling_channel(found)
    name = found.channels[channel]
    grid["signal"].sharex(grid["left"])
    plots.draw_window(grid["signal"], grid["left"], found.nominal, found.final, channel, name, of_channel(found, name, units))
    _, what = fingerprints(found)[0]
    grid["after"].sharey(grid["before"])
    panels = (grid["before"], grid["after"])
    plots.draw_fingerprint(panels, found.nominal, found.final, found.channels.index(what.channel), what, found.rig.rig, units)
    with whole_file(path, "picture") as temporary:
        figure.savefig(temporary, format="png", dpi=100)
