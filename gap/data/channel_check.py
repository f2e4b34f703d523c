"""One channel of one log on its own: is it stuck, clipped, coarser than declared, or cut off at the end of its range?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from config.plant_sensor import Sensor
from gap.data.measured import Array, Channel, Measured, runs

CLIPPED = 0.02  # share of samples at the ends of the sensor's range
CENSORED = 0.2
COARSE = 3.0  # declared resolutions
_FLAT_ROWS = 5  # a flat top at least this long …
_STEEP = 3.0  # … entered and left by steps of at least this many quanta a row is no turning point
_LIVELY = ("pressure_a", "pressure_b", "deflection", "acceleration")  # these cannot stand still while a joint moves


@dataclass(frozen=True, slots=True)
class DataProblem:
    """One finding about the data. `fatal`: no verdict about the physics can be given."""

    what: str
    channel: str
    where: str
    fatal: bool

    def text(self) -> str:
        return f"{self.where}: {self.channel + ': ' if self.channel else ''}{self.what}"


def channel_problems(log: Measured, channel: Channel, sensor: Sensor, moving: bool) -> list[DataProblem]:
    """What is wrong with one channel; `moving`: some joint moves in this log."""
    good = channel.values[np.isfinite(channel.values)]
    checks = (_out_of_range, _constant, _flat_tops, _coarse)
    return [problem for check in checks for problem in check(log, channel, good, sensor, moving)]


def quantum(channel: Channel) -> float:
    """The smallest change of a channel: its quantisation, as far as the data show it."""
    changes = np.abs(np.diff(channel.logged))
    changes = changes[changes > 1e-12 * max(float(np.ptp(channel.logged)), 1e-30)]
    return float(np.quantile(changes, 0.02)) if changes.size > 10 else 0.0


def censored(channel: Channel, low: float, high: float) -> bool:
    """Whether the end of the range cuts off so much that the channel's noise is no noise any more."""
    good = channel.values[np.isfinite(channel.values)]
    return bool(np.mean((good <= low) | (good >= high)) > CENSORED)


def _out_of_range(log: Measured, channel: Channel, good: Array, sensor: Sensor, moving: bool) -> Sequence[DataProblem]:
    low, high = sensor.low, sensor.high
    if np.mean((good < low - 1e-9) | (good > high + 1e-9)) > CLIPPED:
        range_ = f"the sensor's range in the rig file is {low:.6g} to {high:.6g}: wrong unit, swapped channel or another rig"
        return [_problem(log, channel, f"runs from {good.min():.6g} to {good.max():.6g} {channel.unit}, but {range_}", True)]
    if censored(channel, low, high):
        what = "more than a fifth of the samples stand at the end of the sensor's range, where noise is cut off: not compared"
        return [_problem(log, channel, what, False)]
    if np.mean((good <= low) | (good >= high)) > CLIPPED:
        return [_problem(log, channel, "more than 2% of the samples stand at the end of the sensor's range", False)]
    return []


def _constant(log: Measured, channel: Channel, good: Array, sensor: Sensor, moving: bool) -> Sequence[DataProblem]:
    """One exact value from beginning to end."""
    if not moving or np.ptp(good) > 0 or channel.name.endswith(".position"):
        return []
    what = f"stands at exactly {good[0]:.6g} {channel.unit} from t = {log.t_s[0]:.3f} s to the end"
    if channel.name.endswith(_LIVELY):
        return [_problem(log, channel, f"{what} while a joint moves: dead channel", True)]
    noisy = sensor.noise > sensor.resolution
    return [_problem(log, channel, f"{what}, although the rig file gives it noise: dead channel?", False)] if noisy else []


def _flat_tops(log: Measured, channel: Channel, good: Array, sensor: Sensor, moving: bool) -> Sequence[DataProblem]:
    """Flat at its own largest or smallest value, entered and left at speed: clipped before it was logged (a stop is left slowly)."""
    values, step = channel.values, quantum(channel)
    if step == 0.0:
        return []
    for extreme in (good.max(), good.min()):
        if extreme <= sensor.low or extreme >= sensor.high:
            continue  # where the sensor itself ends, the simulated one ends too
        flat = [(a, n) for a, n in runs(values == extreme) if n >= _FLAT_ROWS and _steep_sides(values, a, n, step)]
        rows = sum(n for _, n in flat)
        if rows > CLIPPED * len(good):
            what = f"is cut off at {extreme:.6g} {channel.unit} for {rows * log.period_s:.2f} s, first at t = {log.t_s[flat[0][0]]:.3f} s"
            return [_problem(log, channel, f"{what}: clipped", True)]
    return []


def _steep_sides(values: Array, start: int, length: int, step: float) -> bool:
    before, after = values[max(start - 3, 0) : start + 1], values[start + length - 1 : start + length + 3]
    return all(len(side) == 4 and bool(np.mean(np.abs(np.diff(side))) > _STEEP * step) for side in (before, after))


def _coarse(log: Measured, channel: Channel, good: Array, sensor: Sensor, moving: bool) -> Sequence[DataProblem]:
    """A staircase: the smallest change is much larger than the resolution the rig file declares."""
    step = quantum(channel)
    same = float(np.mean(np.diff(channel.logged) == 0.0)) if channel.logged.size > 1 else 0.0
    if step <= COARSE * sensor.resolution or same < 0.2:
        return []
    what = f"moves in steps of {step:.3g} {channel.unit}; the rig file declares {sensor.resolution:.3g}. The steps count as noise"
    return [_problem(log, channel, what, False)]


def _problem(log: Measured, channel: Channel, what: str, fatal: bool) -> DataProblem:
    return DataProblem(what, channel.name, str(log.path), fatal)
