"""What the demo shows at its end, made from the three logs alone: vibration, plot, timing, re-execution."""

from __future__ import annotations

from dataclasses import dataclass
from math import log10
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from daemon.cli.demo.demo_runs import DemoRuns
from recording.evaluation.plots import vibration_plot
from recording.evaluation.replay import ReplayResult, reexecute
from recording.evaluation.vibration import HoldVibration, decibels, hold_vibration, rms_mps2
from recording.files.reader import Log, read_log

_TIMING = ("late_us", "read_us", "compute_us", "write_us")


@dataclass(frozen=True, slots=True)
class DemoReport:
    """Keyed by the name of the run's filter; the first one is the reference of every dB figure.

    `clocks`: wall or lockstep. `spoiled`: why a run was repeated in lockstep.
    """

    logs: dict[str, Path]
    vibration: dict[str, list[HoldVibration]]
    timing: dict[str, dict[str, str]]
    replayed: dict[str, ReplayResult]
    plot: Path
    clocks: dict[str, str]
    spoiled: dict[str, str]

    @property
    def all_identical(self) -> bool:
        return all(result.identical for result in self.replayed.values())

    @property
    def replays(self) -> dict[str, str]:
        return {name: result.text() for name, result in self.replayed.items()}

    def decibels(self, name: str) -> list[float]:
        """Every hold of one run relative to the first run's."""
        return decibels(self.vibration[name], self._reference)

    def vibration_table(self) -> Table:
        moves = len(self._reference)
        title = "tip vibration 1.0 s after each move: m/s² (dB relative to the first row)"
        table = Table(title=title, title_justify="left", header_style="bold")
        table.add_column("filter")
        for move in range(moves):
            table.add_column(f"move {move + 1}", justify="right")
        table.add_column("rms, dB", justify="right")
        for name, holds in self.vibration.items():
            cells = [f"{hold.amplitude_mps2:.3f} ({level:+.1f})" for hold, level in zip(holds, self.decibels(name), strict=True)]
            table.add_row(name, *cells, f"{self.rms_decibels(name):+.1f}")
        return table

    def rms_decibels(self, name: str) -> float:
        return 20 * log10(rms_mps2(self.vibration[name]) / rms_mps2(self._reference))

    @property
    def _reference(self) -> list[HoldVibration]:
        return next(iter(self.vibration.values()))

    def timing_table(self) -> Table | None:
        """Of the runs on the wall clock; None when there is none: in lockstep no time passes."""
        timing = {name: row for name, row in self.timing.items() if self.clocks[name] == "wall"}
        if not timing:
            return None
        table = Table(title="timing of the phases of a cycle, µs: median / 99 % / largest", title_justify="left", header_style="bold")
        table.add_column("")
        for name in timing:
            table.add_column(name, justify="right")
        for heading in next(iter(timing.values())):
            table.add_row(heading, *(row[heading] for row in timing.values()))
        return table

    def seen(self) -> str:
        """The result in a sentence or two."""
        first, best = next(iter(self.vibration)), min(self.vibration, key=self.rms_decibels)
        return (
            f"{first}, the tip still shakes with {rms_mps2(self.vibration[first]):.3f} m/s² (rms of the moves) a second after a move; "
            f"{best} leaves {rms_mps2(self.vibration[best]):.3f} m/s² ({self.rms_decibels(best):+.1f} dB)."
        )

    def as_dict(self) -> dict[str, Any]:
        """The same facts for scripts."""
        return {
            "logs": {name: str(path) for name, path in self.logs.items()},
            "hold_vibration_mps2": {name: [hold.amplitude_mps2 for hold in holds] for name, holds in self.vibration.items()},
            "hold_vibration_dB": {name: self.decibels(name) for name in self.vibration},
            "rms_dB": {name: self.rms_decibels(name) for name in self.vibration},
            "timing": self.timing,
            "replay": {name: {"identical": result.identical, "cycles": result.cycles} for name, result in self.replayed.items()},
            "plot": str(self.plot),
            "clock": self.clocks,
            "spoiled": self.spoiled,
        }


def make_report(runs: DemoRuns, out: Path) -> DemoReport:
    """Read the logs, measure, plot and re-execute."""
    logs = runs.logs
    read = {name: read_log(path) for name, path in logs.items()}
    plot = out / "tip-vibration.png"
    vibration_plot(list(read.values()), list(read), plot)
    return DemoReport(
        logs=logs,
        vibration={name: hold_vibration(log) for name, log in read.items()},
        timing={name: timing_summary(log) for name, log in read.items()},
        replayed={name: reexecute(path) for name, path in logs.items()},
        plot=plot,
        clocks=runs.clocks,
        spoiled=runs.spoiled,
    )


def timing_summary(log: Log) -> dict[str, str]:
    """Cycles, overruns, drops and the percentiles of each phase, from the cycles themselves."""
    columns = log.columns
    row = {"cycles": str(log.cycles), "overruns": str(int(columns["overruns"][-1])), "drops": str(int(columns["drops"][-1]))}
    for phase in _TIMING:
        values = columns[phase][~np.isnan(columns[phase])]
        cells = [f"{figure:.0f}" for figure in np.quantile(values, (0.5, 0.99, 1.0))] if len(values) else ["-"]
        row[phase.removesuffix("_us")] = "/".join(cells)
    return row
