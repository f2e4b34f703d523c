"""Figures 2 to 6 and 8 of the paper from the running code, with what is different in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi
from typing import Any

import control
import numpy as np
from matplotlib.figure import Figure

from config.schema.rig import Rig
from sim_backend.kernel.warm_up import warm_up
from tuning.arrays import Complexes
from tuning.experiments.five_hours import stated_flow
from tuning.experiments.sine_test import SineTest, rotary, velocity_response
from tuning.limit_cycles.describing_function import FrictionCompliance
from tuning.limit_cycles.exact_cycle import ExactLoop
from tuning.paper.row import PAYLOAD_KG, SWEEP_HZ
from tuning.paper.rows_cycles import predictions
from tuning.paper.rows_link import EXTENSIONS_IN, PAYLOADS_LB, map_of_frequencies
from tuning.transfer import EQ4
from tuning.variants import PRISMATIC, with_valve

RATIOS = (1.0, 1.1, 1.2)
GAINS = (0.8, 1.0, 1.2)
Bode = Sequence[tuple[str, Complexes, str]]  # label, response per V, line style


def figure_2(rig: Rig) -> Figure:
    ran = warm_up(rig, stated_flow(), 1.0, 22.0)
    figure, axes = _axes(1)
    for name, label in (("supply_temperature", "supply port"), ("reservoir_temperature", "reservoir")):
        axes[0].plot(ran["t_s"] / 3600.0, ran[name], label=label)
    _finish(axes[0], "time, h", "oil temperature, °C")
    return figure


def figure_3(rig: Rig) -> Figure:
    """Bounds by temperature at 0.1 V beside the paper's Eq 4 × {0.8, 1, 1.2}."""
    s = 2j * pi * np.array(SWEEP_HZ)
    lines: list[tuple[str, Complexes, str]] = [(f"Eq 4 × {k:g}", k * EQ4(s) * s, ":") for k in GAINS]
    lines += [(f"{t:g} °C", np.degrees(1.0) * velocity_response(rig, rotary(t), 0.1, SWEEP_HZ), "-") for t in (22.0, 40.0, 56.0)]
    return _bode(lines, "velocity per command, dB re 1 °/s/V")


def figure_4(rig: Rig) -> Figure:
    """Prismatic joint, valve null in the middle (full) and adjusted as shipped (dotted)."""
    lines: list[tuple[str, Complexes, str]] = []
    for variant, style, tag in ((with_valve(rig, PRISMATIC, null_adjustment=0.0), "-", ""), (rig, ":", ", null adjusted")):
        for volts in (0.1, 0.2, 0.5, 1.0):
            response = velocity_response(variant, SineTest(PRISMATIC, PAYLOAD_KG), volts, SWEEP_HZ)
            lines.append((f"{volts:g} V{tag}", response / 0.0254, style))
    return _bode(lines, "velocity per command, dB re 1 in/s/V")


def figure_5(rig: Rig) -> Figure:
    lines = [
        (f"{volts:g} V", np.degrees(1.0) * velocity_response(rig, rotary(), volts, SWEEP_HZ), "-") for volts in (0.1, 0.2, 0.3, 0.5, 1.0)
    ]
    return _bode(lines, "velocity per command, dB re 1 °/s/V")


def figure_6(_: Rig) -> Figure:
    """Left: Nyquist picture. Right: the cycle's frequency over the gain, describing function (dotted) and exact (full)."""
    figure, (nyquist, cycles) = _axes(2)
    omega = 2.0 * pi * np.geomspace(0.2, 60.0, 600)
    for k in GAINS:
        response = k * EQ4(1j * omega)
        nyquist.plot(response.real, response.imag, "k", lw=1)
        at = k * EQ4(2j * pi * np.array([0.5, 1.0, 5.0, 6.0]))
        nyquist.plot(at.real, at.imag, "k.")
    gains = np.geomspace(0.5, 3.4, 30)
    for ratio in RATIOS:
        element = FrictionCompliance.of_ratio(ratio)
        curve = -1.0 / element.describing_function(element.smallest_amplitude * (1.0 + np.geomspace(1e-6, 50.0, 600)))
        nyquist.plot(curve.real, curve.imag, label=f"−1/N, H_s/H_c = {ratio:g}")
        exact = [ExactLoop(float(k) * EQ4, element).march(1.0) for k in gains]
        line = cycles.plot(gains, [c.frequency_Hz if c else np.nan for c in exact], label=f"exact, {ratio:g}")[0]
        dots = [(k, p.frequency_Hz) for k in gains for p in predictions(float(k), ratio) if p.stable]
        if dots:
            cycles.plot(*np.array(dots).T, ".", ms=3, color=line.get_color())
    cycles.axhspan(5.0, 6.0, color="0.9", label="the paper's 5–6 Hz")
    nyquist.set(xlim=(-3.0, 0.2), ylim=(-10.0, 1.0))
    _finish(nyquist, "real (dots: 0.5, 1, 5, 6 Hz)", "imaginary")
    _finish(cycles, "gain factor on Eq 4", "limit cycle, Hz (dots: describing function)")
    return figure


def figure_8(rig: Rig) -> Figure:
    table = map_of_frequencies(rig)
    figure, axes = _axes(1)
    for pounds, rows in zip(PAYLOADS_LB, table, strict=True):
        line = axes[0].semilogy(EXTENSIONS_IN, rows[:, 0], label=f"{pounds} lb")[0]
        axes[0].semilogy(EXTENSIONS_IN, rows[:, 2], "o", ms=3, color=line.get_color())
    _finish(axes[0], "extension, in", "first frequency, Hz (dots: beam equation)")
    return figure


def _bode(lines: Bode, unit: str) -> Figure:
    figure, (gain, phase) = _axes(2)
    for label, response, style in lines:
        measured = control.frd(response, 2.0 * pi * np.array(SWEEP_HZ))
        control.bode_plot(measured, ax=np.array([[gain], [phase]]), dB=True, Hz=True, title="", label=label, linestyle=style)
    _finish(gain, "frequency, Hz", unit)
    _finish(phase, "frequency, Hz", "phase, °")
    return figure


def _axes(count: int) -> tuple[Figure, Sequence[Any]]:
    figure = Figure(figsize=(5.2 * count, 3.4), layout="constrained")
    return figure, [figure.add_subplot(1, count, i + 1) for i in range(count)]


def _finish(axes: Any, x: str, y: str) -> None:
    axes.set(xlabel=x, ylabel=y)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7)


FIGURES: tuple[tuple[str, str, Callable[[Rig], Figure]], ...] = (
    ("Figure 2", "Oil temperature over five hours; the curve of the paper was not available, thermal constants are assumed.", figure_2),
    ("Figure 3", "Bounds on the rotary joint's dynamics: Eq 4 and its ±20 %, and the plant at 0.1 V over temperature.", figure_3),
    ("Figure 4", "Amplitude sensitivity of the prismatic joint.", figure_4),
    ("Figure 5", "Amplitude sensitivity of the rotary joint.", figure_5),
    ("Figure 6", "Describing function and Eq 4. The crossings the paper reads at 5–6 Hz are not there.", figure_6),
    ("Figure 8", "First frequency of the link over extension and payload.", figure_8),
)
