"""Pictures of logs for a screen or a projector: one of everything in a log, one that compares tip vibration of several runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle
from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from config.errors import LogError
from config.stated_sentences import Conversion
from config.whole_file import whole_file
from recording.evaluation.chosen_signals import column_conversions
from recording.evaluation.spectrum import hann_spectrum, without_gaps
from recording.evaluation.vibration import TIP
from recording.files.reader import Log
from servo_control.signals import Mode

_STYLE = {
    "font.size": 14,
    "axes.titlesize": 15,
    "legend.fontsize": 12,
    "legend.handlelength": 1.4,
    "legend.columnspacing": 0.8,
    "legend.borderpad": 0.0,
    "lines.linewidth": 1.6,
    "axes.grid": True,
    "grid.alpha": 0.3,
}
_SIZE_IN = (16.0, 9.0)
_DOTS_PER_INCH = 110
_LEGEND_ROW_POINTS = 18
_SPECTRUM_FLOOR = 1e-5  # of the top of the panel
_BAND_HZ = (0.5, 25.0)
_COLOURS = ("#777777", "#d62728", "#1f77b4", "#2ca02c", "#9467bd", "#ff7f0e")

DEFLECTION = "tip.deflection_m"

Floats = npt.NDArray[np.float64]
Units = Mapping[str, Conversion]


def plot_log(log: Log, out: str | Path, si: bool = False) -> None:
    """PNG with a column of panels for each joint (position, error, command) and one for tip and pressures, where there are numbers.

    In the units of the log's rig file; what it does not state, and all of it with `si`, in rad, m, m/s², mm and MPa.
    """
    units = {} if si else column_conversions(log)
    columns = [_joint_panels(log, joint, units) for joint in log.layout.joint_names] + [_rig_panels(log, units)]
    columns = [panels for panels in columns if panels]
    with rc_context(_STYLE):
        figure = Figure(figsize=_SIZE_IN, layout="constrained")
        parts = figure.subfigures(1, len(columns), squeeze=False)[0]
        for part, panels in zip(parts, columns, strict=True):
            axes = part.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
            for axis, panel in zip(axes, panels, strict=True):
                panel.draw(axis, log)
            axes[-1].set_xlabel("time / s")
        figure.suptitle(_title(log))
        _save(figure, out)


def vibration_plot(logs: Sequence[Log], labels: Sequence[str], out: str | Path) -> None:
    """PNG: tip acceleration of several runs over time, one strip each at one scale, and their spectra in one panel.

    Time counts from each log's first running cycle. Raises LogError for a log without tip acceleration.
    """
    traces = [_tip_trace(log) for log in logs]
    largest = max(float(np.max(np.abs(values))) for _, values in traces)
    with rc_context(_STYLE):
        figure = Figure(figsize=_SIZE_IN, layout="constrained")
        left, right = figure.subfigures(1, 2, width_ratios=(3, 2), squeeze=False)[0]
        strips = left.subplots(len(logs), 1, sharex=True, squeeze=False)[:, 0]
        spectrum = right.subplots()
        for number, (axis, (t, values), label) in enumerate(zip(strips, traces, labels, strict=True)):
            colour = _COLOURS[number % len(_COLOURS)]
            axis.plot(t, values, color=colour)
            axis.set_ylim(-1.08 * largest, 1.08 * largest)
            axis.set_title(label, loc="left")
            frequency, amplitude = hann_spectrum(values, float(np.median(np.diff(t))))
            band = (frequency >= _BAND_HZ[0]) & (frequency <= _BAND_HZ[1])
            spectrum.semilogy(frequency[band], amplitude[band], color=colour, label=label)
        left.supylabel("tip acceleration / (m/s²)")
        strips[-1].set_xlabel("time since the run began / s")
        _label_spectrum(spectrum)
        figure.suptitle("Vibration of the tip")
        _save(figure, out)


def _label_spectrum(axes: Axes) -> None:
    axes.set(title="spectrum (Hann window)", xlabel="frequency / Hz", ylabel="amplitude / (m/s²)", xlim=_BAND_HZ)
    axes.set_ylim(bottom=_SPECTRUM_FLOOR * axes.get_ylim()[1])
    axes.legend()


class _Panel:
    """Lines in one coordinate system. `shown`: unit on the axis, and factor and offset that lead to it from the log's."""

    def __init__(self, title: str, shown: Conversion, lines: dict[str, Floats]) -> None:
        self.title, (self.unit, self.factor, self.offset) = title, shown
        self.lines = {label: values for label, values in lines.items() if np.any(np.isfinite(values))}

    def draw(self, axis: Axes, log: Log) -> None:
        t = log.columns["t_s"]
        for (label, values), dashes in zip(self.lines.items(), cycle(("-", "--", ":", "-.")), strict=False):
            axis.plot(t, self.factor * values + self.offset, dashes, label=label)
        _shade_faults(axis, t, log)
        axis.set_ylabel(self.unit)
        legend_columns = 3 if len(self.lines) <= 3 else 2
        legend_rows = 0 if len(self.lines) == 1 else -(-len(self.lines) // legend_columns)
        axis.set_title(self.title, loc="left", pad=6 + _LEGEND_ROW_POINTS * legend_rows)
        if legend_rows:  # between title and panel, where it hides nothing
            axis.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=legend_columns, frameon=False).set_in_layout(False)


def _joint_panels(log: Log, joint: str, units: Units) -> list[_Panel]:
    column = {name: log.columns[f"{joint}.{name}"] for name in ("position", "reference", "target", "command_V")}
    shaped = not np.array_equal(column["target"], column["reference"], equal_nan=True)
    unit = next(field.unit for field in log.layout.fields if field.name == f"{joint}.position") or "rad or m"
    shown = units.get(f"{joint}.position", (unit, 1.0, 0.0))
    difference = (shown[0], shown[1], 0.0)
    panels = [
        _Panel(f"{joint} position", shown, {name: column[name] for name in ("position", "reference", *(["target"] * shaped))}),
        _Panel(f"{joint} error (reference - position)", difference, {"error": column["reference"] - column["position"]}),
        _Panel(f"{joint} command", ("V", 1.0, 0.0), {"command": column["command_V"]}),
    ]
    return [panel for panel in panels if panel.lines]


def _rig_panels(log: Log, units: Units) -> list[_Panel]:
    nothing = np.full(log.cycles, np.nan)
    pressures = {
        f"{joint} {port}": log.columns[f"{joint}.{port}_pressure_Pa"] for joint in log.layout.joint_names for port in ("supply", "return")
    }
    chambers = {f"{joint} {side}": log.columns[f"{joint}.pressure_{side}_Pa"] for joint in log.layout.joint_names for side in ("a", "b")}
    first = log.layout.joint_names[0]
    MPa = ("MPa", 1e-6, 0.0)
    panels = [
        _Panel("tip acceleration", units.get(TIP, ("m/s²", 1.0, 0.0)), {"acceleration": log.columns.get(TIP, nothing)}),
        _Panel("tip deflection", units.get(DEFLECTION, ("mm", 1e3, 0.0)), {"deflection": log.columns.get(DEFLECTION, nothing)}),
        _Panel("pressure", units.get(f"{first}.supply_pressure_Pa", MPa), pressures),
        _Panel("chamber pressure", units.get(f"{first}.pressure_a_Pa", MPa), chambers),
    ]
    return [panel for panel in panels if panel.lines]


def _shade_faults(axis: Axes, t: Floats, log: Log) -> None:
    fault = log.columns["mode"] == Mode.FAULT
    if fault.any():
        axis.fill_between(t, 0, 1, where=fault, transform=axis.get_xaxis_transform(), color="#d62728", alpha=0.15)


def _title(log: Log) -> str:
    rig = log.metadata.get("recording", {}).get("rig_name") or "unknown rig"
    state = "" if log.complete else " (cut or not closed)"
    return f"{log.path.name}: {rig}, {log.duration_s:.1f} s, {log.kind}{state}"


def _tip_trace(log: Log) -> tuple[Floats, Floats]:
    values = log.columns.get(TIP)
    if values is None or not np.any(np.isfinite(values)):
        raise LogError(
            "the log has no tip acceleration", where=str(log.path), next_step="Plot a log of a rig with an accelerometer at the tip."
        )
    running = np.flatnonzero(log.columns["mode"] == Mode.RUNNING)
    rows = slice(int(running[0]), int(running[-1]) + 1) if len(running) else slice(None)
    t = log.columns["t_s"][rows]
    return t - t[0], without_gaps(values[rows])


def _save(figure: Figure, out: str | Path) -> None:
    FigureCanvasAgg(figure)
    with whole_file(Path(out), "picture") as temporary:
        figure.savefig(temporary, dpi=_DOTS_PER_INCH, format="png")
