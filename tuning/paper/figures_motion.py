"""Figures 9 and 10: tip acceleration on the paper's line, on the whole rig, without filter, with the paper's and with the adaptive one."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from config.schema.rig import Rig
from recording.evaluation.spectrum import hann_spectrum
from tuning.experiments.line_run import LineRun, coupled_run, plan_line, rms_dB, spectrum_dB
from tuning.paper.rows_motion import LINE_Y40
from tuning.variants import as_in_1997

SHAPERS: tuple[tuple[str, dict[str, str]], ...] = (
    ("three-term at the initial frequency", {"kind": "three_term", "focal": "initial"}),
    ("adaptive", {"kind": "adaptive"}),
)


def figures_9_and_10(rig: Rig) -> tuple[list[tuple[str, str, Figure]], str]:
    """Both figures with captions, and a sentence with the reductions."""
    rig = as_in_1997(rig)
    base = coupled_run(rig, plan_line(rig, LINE_Y40))
    shaped = [(name, coupled_run(rig, plan_line(rig, LINE_Y40, shaper))) for name, shaper in SHAPERS]
    words = [
        f"{name}: {spectrum_dB(run, base):.1f} dB in the largest line, {rms_dB(run, base):.1f} dB rms in the holds" for name, run in shaped
    ]
    nine = (
        "Figure 9",
        "Tip acceleration without flexure control, y0 = 40 in, 45 lb, whole rig as shipped.",
        _picture([("no filter", base)]),
    )
    ten = ("Figure 10", "The same with command filters on the rotary joint. " + "; ".join(words) + ".", _picture(shaped))
    return [nine, ten], "; ".join(words)


def _picture(runs: list[tuple[str, LineRun]]) -> Figure:
    figure = Figure(figsize=(10.4, 3.4), layout="constrained")
    left, right = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2)
    for name, run in runs:
        t = run.period_s * np.arange(len(run.tip_acceleration))
        left.plot(t[::5], run.tip_acceleration[::5], lw=0.7, label=name)
        frequencies, lines = hann_spectrum(run.tip_acceleration, run.period_s)
        shown = (frequencies > 0.5) & (frequencies < 25.0)
        right.semilogy(frequencies[shown], lines[shown], lw=0.8, label=name)
    left.set(xlabel="time, s", ylabel="tip acceleration, m/s²", ylim=(-10, 10))
    right.set(xlabel="frequency, Hz", ylabel="spectrum, m/s²", ylim=(1e-3, 5))
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(fontsize=7)
    return figure
