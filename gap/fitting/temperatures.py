"""Temperatures over whole logs: does the simulated oil warm up as the measured one does?

A window is over before anything has warmed up, so temperatures take no part in the search and their heat stores are not fitted. Here the
simulation runs through each log as it did for the windows; the level at the start is the log's own (hose and metal are not measured), what
is compared is the change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from config.schema.rig import Rig
from gap.data.measured import Array
from gap.data.noise import local_variances
from gap.data.windows import Experiment
from gap.fitting.simulate import warmed
from sim_backend.kernel.batch import carry
from sim_backend.memory.layout import Vector

HEAT_KNOWN = 0.25  # relative accuracy of simulated changes: heat capacities and losses are assumed constants
AGREE_WITHIN = 3.0  # standard deviations
_THIRD = 3


@dataclass(frozen=True, slots=True)
class Warming:
    """One thermometer in one log. Changes from the first to the last third of the log, K; `sd`: what noise and heat constants allow."""

    file: str
    channel: str
    measured_K: float
    simulated_K: float
    rms_K: float  # of the difference after its mean is taken out
    offset_K: float  # measured − simulated, mean
    sd_K: float

    @property
    def agrees(self) -> bool:
        return abs(self.measured_K - self.simulated_K) <= AGREE_WITHIN * self.sd_K

    def as_dict(self) -> dict[str, Any]:
        numbers = {"measured_change": self.measured_K, "simulated_change": self.simulated_K, "rms": self.rms_K, "offset": self.offset_K}
        rounded = {name: float(f"{value:.3g}") for name, value in numbers.items()}
        return {"file": self.file, "channel": self.channel, "unit": "K", **rounded, "agrees": self.agrees}

    def text(self) -> str:
        return f"{self.file}: {self.channel}: changes by {self.measured_K:.2g} K, in the simulation by {self.simulated_K:.2g} K"


def warmings(experiments: Sequence[Experiment], p: Vector, rig: Rig) -> list[Warming]:
    """Every thermometer of every log under the parameters `p`; empty where no temperature was logged."""
    names = list(rig.plant.sensors) if rig.plant else []
    found = []
    for experiment in experiments:
        logged = {name: channel for name, channel in experiment.log.temperatures.items() if name in names}
        if not logged:
            continue
        plan = experiment.whole or experiment.plan
        readings, _ = carry(experiment.start, warmed(experiment, p), plan)
        rows = plan.starts[:, None] + np.arange(plan.rows)[None, :]
        for name, channel in logged.items():
            simulated = readings[:, :, names.index(name)].mean(axis=1)
            found.append(_compared(experiment, name, channel.values, rows, simulated))
    return found


def _compared(experiment: Experiment, name: str, values: Array, rows: NDArray[np.int64], simulated: Array) -> Warming:
    """Means over windows: noise is small in them and heat does not move."""
    measured = np.array([np.nanmean(window) if np.isfinite(window).any() else np.nan for window in values[rows]])
    good = np.isfinite(measured)
    measured, simulated = measured[good], simulated[good]
    difference = measured - simulated
    quiet = local_variances(values)
    noise = float(np.sqrt(np.median(quiet) / max(rows.shape[1], 1))) if quiet.size else 0.0
    changes = [_change(series) for series in (measured, simulated)]
    step = float(np.min(np.diff(np.unique(values[np.isfinite(values)])), initial=np.inf))
    coarse = step / np.sqrt(12) if np.isfinite(step) else 0.0
    sd = float(np.hypot(np.hypot(noise, coarse), HEAT_KNOWN * max(abs(change) for change in changes)))
    return Warming(experiment.log.path.name, name, changes[0], changes[1], float(np.std(difference)), float(np.mean(difference)), sd)


def _change(series: Array) -> float:
    third = max(len(series) // _THIRD, 1)
    return float(series[-third:].mean() - series[:third].mean())
