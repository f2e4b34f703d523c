"""Five hours of warming up as one picture: temperatures (Figure 2), rotary joint (Figure 3), error of a move with and without tables."""

from __future__ import annotations

from math import degrees
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from config.whole_file import whole_file
from tuning.oil.warm_up_study import WarmUpStudy
from tuning.paper.row import SWEEP_HZ

UNITS = ((degrees, "rotary: rms error, °"), (lambda metres: 1e3 * metres, "prismatic: rms error, mm"))


def warm_up_plot(study: WarmUpStudy, out: Path) -> None:
    """PNG. WriteError when it cannot be written."""
    figure = Figure(figsize=(12.0, 8.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, 2)
    _temperatures(axes[0, 0], study)
    _responses(axes[0, 1], study)
    for joint in (0, 1):
        _errors(axes[1, joint], study, joint)
    for axis in axes.flat:
        axis.grid(alpha=0.3)
        axis.legend()
    with whole_file(Path(out), "picture") as temporary:
        figure.savefig(temporary, dpi=100, format="png")


def _temperatures(axis: Any, study: WarmUpStudy) -> None:
    hours = study.ran.t_s / 3600.0
    axis.plot(hours, study.ran.supply_C, linewidth=0.8, label="supply port")
    axis.plot(hours, study.ran.metal_C, linewidth=0.8, label="oil in the actuator")
    axis.plot(hours, study.ran.reservoir_C, label="reservoir")
    axis.set(xlabel="time, h", ylabel="temperature, °C", title="Fig 2: the machine's own work, whole plant")


def _responses(axis: Any, study: WarmUpStudy) -> None:
    for moment in study.moments:
        level = 20.0 * np.log10(np.degrees(np.abs(moment.response)))
        axis.semilogx(SWEEP_HZ, level, "o-", label=f"{moment.t_s / 3600.0:.1f} h, {moment.oil_C:.0f} °C")
    axis.set(xlabel="frequency, Hz", ylabel="velocity per command, dB re 1 °/s/V", title="Fig 3: rotary joint at 0.1 V")


def _errors(axis: Any, study: WarmUpStudy, joint: int) -> None:
    scaled, label = UNITS[joint]
    hours = [moment.t_s / 3600.0 for moment in study.moments]
    for name, style in (("without", "s--"), ("with", "o-")):
        axis.plot(hours, [scaled(moment.lag[name].rms[joint]) for moment in study.moments], style, label=f"{name} oil compensation")
    axis.set(xlabel="time, h", ylabel=label, title=study.maneuver, ylim=(0.0, None))
