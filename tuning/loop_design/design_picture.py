"""A design as a picture: sensitivity, complementary sensitivity and gain of stiffness of every plant of the family."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from config.whole_file import whole_file
from tuning.arrays import Complexes, Floats
from tuning.linear.closed_loop import Servo
from tuning.linear.family import compensator_response
from tuning.loop_design.arm_design import ArmDesign
from tuning.loop_design.lag_lead_design import DesignProblem

SPAN_HZ = (0.05, 60.0)


def loops(problem: DesignProblem, servo: Servo, frequencies_Hz: Floats) -> Complexes:
    """L(jω) of every plant of the family, members × frequencies."""
    omega = 2.0 * np.pi * frequencies_Hz
    return np.array([compensator_response(servo, omega) * plant(omega) for plant in problem.plants])


def design_picture(found: ArmDesign, out: Path) -> None:
    """PNG: |S|, |T| and |1 + L|, the chosen servo in colour and the best pure gain in grey. WriteError when it cannot be written."""
    figure = Figure(figsize=(11.0, 11.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(3, 1, sharex=True)
    frequencies = np.geomspace(*SPAN_HZ, 400)
    for servo, style in ((found.pure_gain.servo, {"color": "0.7"}), (found.chosen.servo, {"color": "tab:blue"})):
        loop = loops(found.problem, servo, frequencies)
        for axis, values in zip(axes, (1.0 / (1.0 + loop), loop / (1.0 + loop), 1.0 + loop), strict=True):
            axis.semilogx(frequencies, 20.0 * np.log10(np.abs(values)).T, linewidth=0.8, **style)
    demands = found.problem.demands
    axes[0].axhline(20.0 * np.log10(demands.sensitivity_peak), color="black", linestyle=":", label=f"M_s {demands.sensitivity_peak:g}")
    axes[0].legend()
    axes[2].axvspan(*demands.band_Hz, alpha=0.1, label="band of the search")
    axes[2].legend()
    names = ("sensitivity |S| / dB", "complementary sensitivity |T| / dB", "stiffness over that of the open joint |1 + L| / dB")
    for axis, name in zip(axes, names, strict=True):
        axis.set_ylabel(name)
        axis.grid(alpha=0.3, which="both")
    axes[0].set_title(f"{len(found.problem.plants)} plants: chosen servo in blue, best pure gain in grey")
    axes[2].set_xlabel("frequency / Hz")
    with whole_file(Path(out), "picture") as temporary:
        figure.savefig(temporary, dpi=100, format="png")
