"""The report's pictures, each as an inline PNG with a text that says what it shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from config.schema.rig import Rig
from gap.fitting.evaluation import Evaluation, mean_cost
from gap.outcome.file_units import FileUnits, Shown
from gap.outcome.spectrum_left import spectrum
from gap.report.bootstrap import cost_interval
from gap.report.fingerprint import Fingerprint, abscissa, ordinate, unit_of
from gap.report.inline_picture import inline as _inline
from gap.report.replay import JointReplay

BEFORE, BETWEEN, AFTER, FLOOR_COLOUR = "#c0392b", "#d68910", "#1f7a4d", "#777777"
_BINS = 30
_DOTS = 4000
_WIDTH = 8.0

Stage = tuple[str, Sequence[Evaluation]]


def waterfall(stages: Sequence[Stage], channels: Sequence[str]) -> str:
    """The hold-out's cost from the rig file to the final model: all channels with 95 % intervals, and each channel by itself."""
    figure = Figure(figsize=(_WIDTH, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(5, 3))
    costs = draw_costs(left, stages)
    left.set_title("all channels, 95 % by block bootstrap", fontsize=8)
    _each_channel(right, stages, channels)
    names = [name for name, _ in stages]
    return _inline(figure, f"Cost of the hold-out: {', '.join(f'{n} {c:.3g}' for n, c in zip(names, costs, strict=True))} noise floors")


def draw_costs(axes: Any, stages: Sequence[Stage]) -> list[float]:
    """Bars of the hold-out's cost with 95 % intervals; returns the costs."""
    places = np.arange(len(stages))
    costs = np.array([mean_cost(evaluations) for _, evaluations in stages])
    spans = np.array([cost_interval(evaluations) for _, evaluations in stages])
    colours = [BEFORE, *[BETWEEN] * (len(stages) - 2), AFTER][: len(stages)]
    axes.bar(places, costs, width=0.6, color=colours, log=True)
    axes.errorbar(places, costs, np.abs(spans.T - costs), fmt="none", ecolor="black", capsize=4, linewidth=1)
    low = min(0.5, costs.min() / 2)
    axes.set_ylim(low, spans.max() * (spans.max() / low) ** 0.18)  # room for the numbers above the bars
    for k, (cost, span) in enumerate(zip(costs, spans, strict=True)):
        text = f"{cost:.3g}\n({span[0]:.3g} to {span[1]:.3g})"
        axes.annotate(text, (k, span[1] * 1.12), ha="center", va="bottom", fontsize=6)
    axes.set_ylabel("cost of the hold-out (noise floors)", fontsize=8)
    _stage_axis(axes, stages)
    return [float(cost) for cost in costs]


def _each_channel(axes: Any, stages: Sequence[Stage], channels: Sequence[str]) -> None:
    for k, name in enumerate(channels):
        values = [float(np.mean([e.channel_costs[k] for e in evaluations])) for _, evaluations in stages]
        axes.plot(np.arange(len(stages)), values, "o-", markersize=3, linewidth=1, label=name)
    axes.set_yscale("log")
    axes.set_title("each channel", fontsize=8)
    axes.legend(fontsize=6, loc="upper right")
    axes.set_xlim(-0.3, len(stages) - 0.7)
    _stage_axis(axes, stages)


def _stage_axis(axes: Any, stages: Sequence[Stage]) -> None:
    axes.axhline(1.0, color=FLOOR_COLOUR, linestyle="--", linewidth=1)
    axes.set_xticks(np.arange(len(stages)), [name for name, _ in stages], rotation=20, ha="right", fontsize=7)
    axes.tick_params(axis="y", labelsize=7)


def before_and_after(stages: Sequence[Stage], channel: int, name: str, shown: Shown) -> str:
    """The gap on one screen: the hold-out's cost at two stages, and the window where the gap was largest, start states at their best."""
    figure = Figure(figsize=(_WIDTH, 3.1), layout="constrained")
    grid: dict[str, Any] = figure.subplot_mosaic([["costs", "signal"], ["costs", "left"]], width_ratios=(2, 5))
    grid["signal"].sharex(grid["left"])
    before, after = stages
    draw_costs(grid["costs"], [before, after])
    start_s = draw_window(grid["signal"], grid["left"], before[1], after[1], channel, name, shown)
    return _inline(figure, f"The gap before and after: cost of the hold-out, and {name} in the window from {start_s:.2f} s")


def draw_window(
    top: Any, bottom: Any, before: Sequence[Evaluation], after: Sequence[Evaluation], channel: int, name: str, shown: Shown
) -> float:
    """Signals above, what is left of them below; returns the window's start."""
    log, window = _largest(before, channel)
    experiment, unit = before[log].experiment, shown.unit
    t, measured = experiment.times_s[window], experiment.measured[window, :, channel]
    sigma = experiment.sigma[channel]
    top.plot(t, shown.of(measured), color="black", linewidth=2.5, label="measured")
    for evaluation, colour, label, style in ((before[log], BEFORE, "rig file", "-"), (after[log], AFTER, "improved", "--")):
        left = _left(evaluation, channel)[window] * sigma
        top.plot(t, shown.of(measured - left), style, color=colour, linewidth=1.2, label=label)
        bottom.plot(t, shown.factor * left, color=colour, linewidth=1, label=label)
    bottom.axhspan(-2 * shown.factor * sigma, 2 * shown.factor * sigma, color=FLOOR_COLOUR, alpha=0.3, label="noise, 2 sd")
    top.set_ylabel(f"{name} ({unit})" if unit else name, fontsize=8)
    bottom.set_ylabel(f"left over ({unit})" if unit else "left over", fontsize=8)
    bottom.set_xlabel("t (s)", fontsize=8)
    for axes in (top, bottom):
        axes.legend(fontsize=7, loc="best")
        axes.tick_params(labelsize=7)
    return float(t[0])


def fingerprint(
    before: Sequence[Evaluation], after: Sequence[Evaluation], channel: int, what: Fingerprint, rig: Rig, units: FileUnits
) -> str:
    """What is left over against the effect's own variable, with the mean of every bin: the effect's shape before, nothing after."""
    figure = Figure(figsize=(_WIDTH, 3.0), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    draw_fingerprint(panels, before, after, channel, what, rig, units)
    return _inline(figure, f"{what.left} of {what.channel} against {what.variable}, before and after")


def draw_fingerprint(
    panels: Any, before: Sequence[Evaluation], after: Sequence[Evaluation], channel: int, what: Fingerprint, rig: Rig, units: FileUnits
) -> None:
    """One panel before, one after, on one scale."""
    highest, over, size = 0.0, units.channel(what.variable, unit_of(what.variable, rig)), units.channel(what.channel, what.unit)
    for axes, evaluations, colour, title in zip(panels, (before, after), (BEFORE, AFTER), ("rig file", "improved"), strict=True):
        x = np.concatenate([abscissa(e, what.variable, rig).ravel() for e in evaluations])
        y = np.concatenate([ordinate(e, channel, what.derivative).ravel() for e in evaluations])
        there = np.isfinite(x) & np.isfinite(y)
        x, y = over.of(x[there]), size.factor * y[there]
        pick = np.random.default_rng(0).permutation(x.size)[:_DOTS]
        axes.plot(x[pick], y[pick], ".", markersize=1.5, color=colour, alpha=0.35)
        axes.plot(*_bin_means(x, y), color="black", linewidth=1.5, label="mean of each bin")
        axes.axhline(0.0, color=FLOOR_COLOUR, linewidth=0.8)
        axes.set_title(title, fontsize=8)
        axes.set_xlabel(_labelled(what.variable.removesuffix("_V"), over.unit), fontsize=8)
        axes.tick_params(labelsize=7)
        highest = max(highest, float(np.quantile(np.abs(y), 0.995)))
    panels[0].set_ylim(-1.1 * highest, 1.1 * highest)
    panels[0].set_ylabel(f"{what.channel}:\n{_labelled(what.left, size.unit if what.unit else '')}", fontsize=8)
    panels[0].legend(fontsize=7)


def _labelled(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def _bin_means(x: Any, y: Any) -> tuple[Any, Any]:
    """Means over equally wide bins, a gap where a bin is all but empty."""
    low, high = np.quantile(x, (0.002, 0.998))
    edges = np.linspace(low, high, _BINS + 1)
    number = np.clip(np.searchsorted(edges, x) - 1, 0, _BINS - 1)
    counts = np.bincount(number, minlength=_BINS)
    sums = np.bincount(number, weights=y, minlength=_BINS)
    return 0.5 * (edges[1:] + edges[:-1]), np.where(counts >= 5, sums / np.maximum(counts, 1), np.nan)


def spectra(before: Sequence[Evaluation], after: Sequence[Evaluation], channel: int, name: str) -> str:
    """Power of what is left over, over that of the noise."""
    figure = Figure(figsize=(_WIDTH, 2.8), layout="constrained")
    axes = figure.subplots()
    for evaluations, colour, label in ((before, BEFORE, "rig file"), (after, AFTER, "improved")):
        frequency, density = spectrum(evaluations, channel)
        axes.loglog(frequency, np.maximum(density, 1e-3), color=colour, label=label)
    axes.axhline(1.0, color=FLOOR_COLOUR, linestyle="--", linewidth=1, label="noise floor")
    axes.set_xlabel("frequency (Hz)", fontsize=8)
    axes.set_ylabel(f"{name}\npower left over / noise", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.legend(fontsize=7)
    return _inline(figure, f"Spectrum of what is left of {name}")


def carried(discrepancy: dict[str, Any]) -> str:
    """The imbalance of an equation over each input that carries it."""
    inputs = discrepancy["carried_by"]
    figure = Figure(figsize=(_WIDTH, 2.6), layout="constrained")
    for axes, item in zip(figure.subplots(1, len(inputs), squeeze=False)[0], inputs, strict=True):
        axes.plot(item["at"], item["value"], "-o", color=AFTER, linewidth=1, markersize=3)
        axes.axhline(0.0, color=FLOOR_COLOUR, linewidth=0.7)
        axes.set_xlabel(f"{item['input']} ({item['share']:.0%})", fontsize=8)
        axes.set_ylabel(f"imbalance ({discrepancy['unit']})", fontsize=8)
        axes.tick_params(labelsize=7)
    return _inline(figure, f"Imbalance of the {discrepancy['equation']} over {', '.join(item['input'] for item in inputs)}")


def closed_loop_replay(replay: JointReplay, shown: Shown) -> str:
    """Command and tracking error of one joint over the whole run: measured, and simulated with either file."""
    figure = Figure(figsize=(_WIDTH, 4.0), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True)
    drawn = (replay.commands_V, tuple(shown.factor * errors for errors in replay.errors))
    for axes, values, label in zip(panels, drawn, ("command (V)", f"tracking error ({shown.unit})"), strict=True):
        for series, colour, name, style in zip(
            values, ("black", BEFORE, AFTER), ("measured", "rig file", "improved"), ("-", "-", "--"), strict=True
        ):
            axes.plot(replay.t_s, series, style, color=colour, linewidth=1, label=name)
        axes.set_ylabel(label, fontsize=8)
        axes.tick_params(labelsize=7)
    panels[0].legend(fontsize=7, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    panels[1].set_xlabel("t since the start of the run (s)", fontsize=8)
    return _inline(figure, f"Closed loop of {replay.joint}: command and tracking error, measured and simulated")


def _left(evaluation: Evaluation, channel: int) -> Any:
    shape = evaluation.experiment.measured.shape
    return evaluation.left[:, : shape[1] * shape[2]].reshape(shape)[:, :, channel]


def _largest(evaluations: Sequence[Evaluation], channel: int) -> tuple[int, int]:
    """Log and window with the largest rest in a channel."""
    sizes = [np.mean(_left(e, channel) ** 2, axis=1) for e in evaluations]
    log = int(np.argmax([size.max() for size in sizes]))
    return log, int(np.argmax(sizes[log]))
