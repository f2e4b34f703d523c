"""Steps of a reading that the data show by themselves: every value of every log a multiple of one step that the rig file does not have.

The comparison counts such steps as noise (nothing finer was measured), so no fit can find them; the values themselves do. Chance is
excluded by counting: were the steps those of the declared resolution, one value in m would lie on the coarser ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from config.effects_link_sensor import SIGNAL_UNITS
from config.rig import Rig
from config.signals import signal_measures
from gap.data.channel_check import quantum
from gap.data.measured import Array, Measured

_COARSER = 1.5  # declared resolutions
_LEAST_CHANGES = 30  # of a reading in one log: fewer levels than that share a divisor by chance
_ON = 0.02  # of a step: so close to its multiples, as far as a text file rounds them


@dataclass(frozen=True, slots=True)
class CoarseStep:
    """A reading that moves in steps of `step` (SI, in `unit`) where the rig file declares `resolution`. `changes`: in the hold-out logs.
    `declared`: share of the steps' variance that the declared noise and resolution have."""

    signal: str
    step: float
    unit: str
    resolution: float
    changes: int
    declared: float

    @property
    def where(self) -> str:
        return f"sensor:{self.signal}"

    @property
    def gain(self) -> float:
        """Share of the channel's noise floor that the steps make and the rig file does not have."""
        return 1.0 - self.declared

    @property
    def t(self) -> float:
        """Standard deviations by which the hold-out's values lie on the steps more often than by chance, a share 1/m of them."""
        return float(np.sqrt(self.changes * max(self.step / self.resolution - 1.0, 0.0)))

    def text(self) -> str:
        times = f"{self.step / self.resolution:.3g} times the {self.resolution:.3g} {self.unit} of the rig file"
        return f"{self.signal} moves in steps of {self.step:.4g} {self.unit}, {times}: every value of every log lies on them"


def coarse_steps(fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], rig: Rig) -> list[CoarseStep]:
    """Of every sensor that all logs have, fit logs and hold-out alike; only steps that outweigh what the rig file declares as noise."""
    assert rig.plant is not None
    kinds = signal_measures({name: joint.motion for name, joint in rig.plant.joints.items()})
    present = {(entry.effect, entry.where) for entry in rig.plant.effects}
    found = []
    for signal, sensor in rig.plant.sensors.items():
        logs = [[log.channels[signal].values for log in group if signal in log.channels] for group in (fit_logs, holdout_logs)]
        if [len(group) for group in logs] != [len(fit_logs), len(holdout_logs)] or ("sensor_quantization", f"sensor:{signal}") in present:
            continue
        step = _common([quantum(log.channels[signal]) for log in (*fit_logs, *holdout_logs)])
        declared = (sensor.noise**2 + sensor.resolution**2 / 12) / max(step**2 / 12, 1e-300)
        if step < _COARSER * sensor.resolution or declared > 1.0 or not all(_on_steps(v, step) for group in logs for v in group):
            continue
        changes = sum(int(np.count_nonzero(_changes(values))) for values in logs[1])
        found.append(CoarseStep(signal, _refined(logs[0][0], step), SIGNAL_UNITS[kinds[signal]], sensor.resolution, changes, declared))
    return found


def _common(steps: Sequence[float]) -> float:
    """The one step of all logs; 0 when they differ."""
    return steps[0] if max(steps) - min(steps) <= _ON * max(steps) else 0.0


def _on_steps(values: Array, step: float) -> bool:
    """Whether every value is a whole number of steps away from the first, and enough of them differ."""
    good = values[np.isfinite(values)]
    away = (good - good[0]) / step
    return bool(np.count_nonzero(_changes(good)) >= _LEAST_CHANGES and np.max(np.abs(away - np.rint(away))) <= _ON)


def _changes(values: Array) -> Array:
    good = values[np.isfinite(values)]
    return np.asarray(np.diff(good)[np.abs(np.diff(good)) > 0.0])


def _refined(values: Array, step: float) -> float:
    """The step from the widest travel: a text file rounds every value, and the error of one change is not multiplied."""
    span = float(np.nanmax(values) - np.nanmin(values))
    return span / max(round(span / step), 1)
