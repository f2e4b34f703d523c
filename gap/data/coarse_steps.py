"""Steps of a reading that the data show by themselves: every logged value a multiple of one step that the rig file does not have.

The comparison counts such steps as noise (nothing finer was measured), so no fit can find them; the values themselves do. Chance is
excluded by counting: were the steps those of the declared resolution, one value in m would lie on the coarser ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from config.schema.effect_entry import READING
from config.schema.plant_sensor import Sensor
from config.schema.rig import Rig
from config.signal_names import signal_measures
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
    for signal, step in _steps([*fit_logs, *holdout_logs], rig).items():
        sensor = rig.plant.sensors[signal]
        if step < smallest_step(sensor) or ("sensor_quantization", f"sensor:{signal}") in present:
            continue
        changes = sum(len(_changes(log.channels[signal].logged)) for log in holdout_logs)
        refined = _refined(fit_logs[0].channels[signal].logged, step)
        share = (sensor.noise**2 + sensor.resolution**2 / 12) / (refined**2 / 12)
        found.append(CoarseStep(signal, refined, READING[kinds[signal]], sensor.resolution, changes, share))
    return found


def smallest_step(sensor: Sensor) -> float:
    """The smallest step that is named: coarser than the declared resolution, and of more variance than the declared noise."""
    return max(_COARSER * sensor.resolution, float(np.sqrt(12.0 * sensor.noise**2 + sensor.resolution**2)))


def readable(logs: Sequence[Measured], rig: Rig) -> dict[str, float]:
    """The smallest step that would have been read off these logs, of every signal whose values lie on steps at all, by place."""
    assert rig.plant is not None
    return {f"sensor:{signal}": smallest_step(rig.plant.sensors[signal]) for signal in _steps(logs, rig)}


def _steps(logs: Sequence[Measured], rig: Rig) -> dict[str, float]:
    """The one step of all logs, of every signal that all have, where every value lies on it."""
    assert rig.plant is not None
    found = {}
    for signal in rig.plant.sensors:
        channels = [log.channels[signal] for log in logs if signal in log.channels]
        steps = [quantum(channel) for channel in channels]
        if (
            len(channels) == len(logs)
            and max(steps) - min(steps) <= _ON * max(steps)
            and all(_on_steps(c.logged, steps[0]) for c in channels)
        ):
            found[signal] = steps[0]
    return found


def _on_steps(values: Array, step: float) -> bool:
    """Whether every value is a whole number of steps away from the first, and enough of them differ."""
    if step == 0.0:
        return False
    away = (values - values[0]) / step
    return bool(len(_changes(values)) >= _LEAST_CHANGES and np.max(np.abs(away - np.rint(away))) <= _ON)


def _changes(values: Array) -> Array:
    moves = np.diff(values)
    return np.asarray(moves[moves != 0.0])


def _refined(values: Array, step: float) -> float:
    """The step from the widest travel: a text file rounds every value, and the error of one change is not multiplied."""
    span = float(np.ptp(values))
    return span / max(round(span / step), 1)
