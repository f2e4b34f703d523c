"""The report's pictures, each as an inline PNG."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from config.rig import Rig
from gap.evaluation import Evaluation
from gap.localise import operating_values, spectrum

BEFORE, AFTER, FLOOR_COLOUR = "#c0392b", "#1f7a4d", "#888888"


def waterfall(names: Sequence[str], costs: Sequence[float]) -> str:
    """The hold-out gap from the rig file to the final model, in noise floors."""
    figure = Figure(figsize=(7, 2.8), layout="constrained")
    axes = figure.subplots()
    axes.bar(range(len(costs)), costs, color=[BEFORE, *["#d68910"] * (len(costs) - 2), AFTER][: len(costs)])
    axes.set_yscale("log")
    axes.axhline(1.0, color=FLOOR_COLOUR, linestyle="--", linewidth=1)
    axes.set_xticks(range(len(names)), names, rotation=15, ha="right", fontsize=8)
    axes.set_ylabel("hold-out cost\n(noise floors)")
    for k, cost in enumerate(costs):
        axes.annotate(f"{cost:.3g}", (k, cost), ha="center", va="bottom", fontsize=8)
    return _inline(figure)


def revealing_window(before: Sequence[Evaluation], after: Sequence[Evaluation], channel: int, name: str, unit: str) -> str:
    """Measured and simulated in the window where the gap was largest, before and after."""
    log, window = _largest(before, channel)
    experiment = before[log].experiment
    t, measured = experiment.times_s[window], experiment.measured[window, :, channel]
    figure = Figure(figsize=(7, 3.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    top.plot(t, measured, color="black", linewidth=1.5, label="measured")
    for evaluation, colour, label in ((before[log], BEFORE, "rig file"), (after[log], AFTER, "improved")):
        top.plot(t, evaluation.readings[window, :, channel], color=colour, linewidth=1, label=label)
        left = _left(evaluation, channel)[window] * experiment.sigma[channel]
        bottom.plot(t, left, color=colour, linewidth=1)
    bottom.axhspan(-experiment.sigma[channel], experiment.sigma[channel], color=FLOOR_COLOUR, alpha=0.3)
    top.set_ylabel(f"{name}\n({unit})", fontsize=8)
    bottom.set_ylabel("left over", fontsize=8)
    bottom.set_xlabel("t (s)", fontsize=8)
    top.legend(fontsize=7)
    return _inline(figure)


def fingerprint(before: Sequence[Evaluation], after: Sequence[Evaluation], channel: int, variable: str, rig: Rig) -> str:
    """What is left over against an operating variable, before and after."""
    figure = Figure(figsize=(7, 2.8), layout="constrained")
    for axes, evaluations, colour, title in zip(
        figure.subplots(1, 2, sharey=True), (before, after), (BEFORE, AFTER), ("rig file", "improved"), strict=True
    ):
        x = np.concatenate([operating_values(e, rig)[variable].ravel() for e in evaluations])
        y = np.concatenate([_left(e, channel).ravel() for e in evaluations])
        pick = np.random.default_rng(0).permutation(x.size)[:4000]
        axes.plot(x[pick], y[pick], ".", markersize=1.5, color=colour)
        axes.set_title(title, fontsize=8)
        axes.set_xlabel(variable, fontsize=8)
        axes.set_ylabel("left over (noise sd)", fontsize=8)
    return _inline(figure)


def spectra(before: Sequence[Evaluation], after: Sequence[Evaluation], channel: int, name: str) -> str:
    """Power of what is left over, over that of the noise."""
    figure = Figure(figsize=(7, 2.6), layout="constrained")
    axes = figure.subplots()
    for evaluations, colour, label in ((before, BEFORE, "rig file"), (after, AFTER, "improved")):
        frequency, density = spectrum(evaluations, channel)
        axes.loglog(frequency, np.maximum(density, 1e-3), color=colour, label=label)
    axes.axhline(1.0, color=FLOOR_COLOUR, linestyle="--", linewidth=1, label="noise floor")
    axes.set_xlabel("frequency (Hz)", fontsize=8)
    axes.set_ylabel(f"{name}\nover noise", fontsize=8)
    axes.legend(fontsize=7)
    return _inline(figure)


def _left(evaluation: Evaluation, channel: int) -> Any:
    shape = evaluation.experiment.measured.shape
    return evaluation.left[:, : shape[1] * shape[2]].reshape(shape)[:, :, channel]


def _largest(evaluations: Sequence[Evaluation], channel: int) -> tuple[int, int]:
    """Log and window with the largest rest in a channel."""
    sizes = [np.mean(_left(e, channel) ** 2, axis=1) for e in evaluations]
    log = int(np.argmax([size.max() for size in sizes]))
    return log, int(np.argmax(sizes[log]))


def _inline(figure: Figure) -> str:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return f'<img alt="" src="data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}">'
