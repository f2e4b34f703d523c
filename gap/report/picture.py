"""One picture of a whole search: the cost step by step, the most revealing window, and the effect's fingerprint before and after."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from gap.report import plots
from gap.report.found import Found
from gap.report.shown import fingerprints, stages, telling_channel, unit_of_channel


def write_picture(found: Found, path: Path, title: str) -> None:
    """A PNG file."""
    figure = Figure(figsize=(10, 7), layout="constrained")
    figure.suptitle(title, fontsize=10)
    grid: dict[str, Any] = figure.subplot_mosaic([["costs", "signal"], ["costs", "left"], ["before", "after"]], height_ratios=(1, 1, 1.4))
    plots.draw_costs(grid["costs"], stages(found))
    channel = telling_channel(found)
    name = found.channels[channel]
    grid["signal"].sharex(grid["left"])
    plots.draw_window(grid["signal"], grid["left"], found.nominal, found.final, channel, name, unit_of_channel(found, name))
    _, what = fingerprints(found)[0]
    grid["after"].sharey(grid["before"])
    panels = (grid["before"], grid["after"])
    plots.draw_fingerprint(panels, found.nominal, found.final, found.channels.index(what.channel), what, found.rig.rig)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    figure.savefig(part, format="png", dpi=100)
    os.replace(part, path)
