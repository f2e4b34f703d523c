"""One channel of one log on its own: is it stuck, clipped, coarser than declared, or cut off at the end of its range?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from config.schema.plant_sensor import Sensor
from config.schema.rig import Rig
from gap.data.measured import Array, Measured, MeasuredChannel
from gap.data.uniform_grid import runs

CLIPPED = 0.02  # share of samples at the ends of the sensor's range
BEYOND_SD, BEYOND_SPAN = 3.0, 0.02  # noise about the end of a sensor's range: in standard deviations of the noise, or of the range
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


def channel_problems(log: Measured, channel: MeasuredChannel, sensor: Sensor, moving: bool) -> list[DataProblem]:
    """What is wrong with one channel; `moving`: some joint moves in this log."""
    good = channel.values[np.isfinite(channel.values)]
    checks = (_out_of_range, _quiet_though_noisy, _flat_tops, _coarse)
    found = [problem for check in checks for problem in check(log, channel, good, sensor, moving)]
    why = "" if channel.name.endswith(".position") else not_compared(channel, sensor, moving)
    return [*found, _problem(log, channel, f"{why}: not compared in this log", False)] if why else found


def not_compared(channel: MeasuredChannel, sensor: Sensor, moving: bool) -> str:
    """Why a channel of one log says nothing about the plant; empty where it does."""
    good = channel.values[np.isfinite(channel.values)]
    if censored(channel, sensor.low, sensor.high):
        return "more than a fifth of the samples stand at the end of the sensor's range, where noise is cut off"
    if moving and np.ptp(good) == 0 and channel.name.endswith(_LIVELY):
        return f"stands at exactly {good[0]:.6g} {channel.unit} from beginning to end while a joint moves (dead channel)"
    return ""


def comparable(log: Measured, rig: Rig) -> Measured:
    """The log without the channels that say nothing about the plant. Positions stay: every window starts from them."""
    sensors = rig.plant.sensors if rig.plant else {}
    moving = log_moves(log)
    kept = {
        name: channel
        for name, channel in log.channels.items()
        if name.endswith(".position") or not not_compared(channel, sensors[name], moving)
    }
    return replace(log, channels=kept)


def log_moves(log: Measured) -> bool:
    """Whether some joint moves in this log."""
    return any(moves(channel) for name, channel in log.channels.items() if name.endswith(".position"))


def moves(channel: MeasuredChannel) -> bool:
    """By more than its own steps."""
    good = channel.values[np.isfinite(channel.values)]
    return bool(np.ptp(good) > max(20 * quantum(channel), 1e-9))


def quantum(channel: MeasuredChannel) -> float:
    """The smallest change of a channel: its quantisation, as far as the data show it."""
    changes = np.abs(np.diff(channel.logged))
    changes = changes[changes > 1e-12 * max(float(np.ptp(channel.logged)), 1e-30)]
    return float(np.quantile(changes, 0.02)) if changes.size > 10 else 0.0


def censored(channel: MeasuredChannel, low: float, high: float) -> bool:
    """Whether the end of the range cuts off so much that the channel's noise is no noise any more."""
    good = channel.values[np.isfinite(channel.values)]
    return bool(np.mean((good <= low) | (good >= high)) > CENSORED)


def _out_of_range(log: Measured, channel: MeasuredChannel, good: Array, sensor: Sensor, moving: bool) -> Sequence[DataProblem]:
    low, high = sensor.low, sensor.high
    slack = max(BEYOND_SD * sensor.noise, BEYOND_SPAN * (high - low) if np.isfinite(high - low) else 0.0)
    spans = (
        f"runs from {good.min():.6g} to {good.max():.6g} {channel.unit}, but the sensor's range in the rig file is {low:.6g} to {high:.6g} "
        f"{channel.unit}"
    )
    if np.mean((good < low - slack) | (good > high + slack)) > CLIPPED:
        return [_problem(log, channel, f"{spans}: wrong unit, swapped channel or another rig", True)]
    if np.mean((good < low - 1e-9) | (good > high + 1e-9)) > CLIPPED:
        return [_problem(log, channel, f"{spans}; so little beyond it counts as noise", False)]
    if np.mean((good <= low) | (good >= high)) > CLIPPED and not censored(channel, low, high):
        return [_problem(log, channel, "more than 2% of the samples stand at the end of the sensor's range", False)]
    return []


def _quiet_though_noisy(log: Measured, channel: MeasuredChannel, good: Array, sensor: Sensor, moving: bool) -> Sequence[DataProblem]:
    """One exact value from beginning to end of a slow channel that the rig file gives noise."""
    if not moving or np.ptp(good) > 0 or channel.name.endswith((".position", *_LIVELY)) or sensor.noise <= sensor.resolution:
        return []
    what = f"stands at exactly {good[0]:.6g} {channel.unit} from t = {log.t_s[0]:.3f} s to the end"
    return [_problem(log, channel, f"{what}, although the rig file gives it noise: dead channel?", False)]


def _flat_tops(log: Measured, channel: MeasuredChannel, good: Array, sensor: Sensor, moving: bool) -> Sequence[DataProblem]:
    """What clipped() finds, as a sentence."""
    cut = clipped(channel, sensor)
    if not cut.any():
        return []
    first = int(np.argmax(cut))
    what = f"is cut off at {channel.values[first]:.6g} {channel.unit} for {cut.sum() * log.period_s:.2f} s"
    return [_problem(log, channel, f"{what}, first at t = {log.t_s[first]:.3f} s: clipped; these samples are left out", False)]


def clipped(channel: MeasuredChannel, sensor: Sensor) -> NDArray[np.bool_]:
    """Rows that stand flat at the channel's own largest or smallest value, entered and left at speed: cut off before they were logged (a
    stop is left slowly). None where so few are that they may be turning points."""
    values, step = channel.values, quantum(channel)
    found = np.zeros(len(values), dtype=np.bool_)
    if step == 0.0:
        return found
    for extreme in (np.nanmax(values), np.nanmin(values)):
        if extreme <= sensor.low or extreme >= sensor.high:
            continue  # where the sensor itself ends, the simulated one ends too
        flat = [(a, n) for a, n in runs(values == extreme) if n >= _FLAT_ROWS and _steep_sides(values, a, n, step)]
        if sum(n for _, n in flat) > CLIPPED * np.isfinite(values).sum():
            for start, length in flat:
                found[start : start + length] = True
    return found


def _steep_sides(values: Array, start: int, length: int, step: float) -> bool:
    before, after = values[max(start - 3, 0) : start + 1], values[start + length - 1 : start + length + 3]
    return all(len(side) == 4 and bool(np.mean(np.abs(np.diff(side))) > _STEEP * step) for side in (before, after))


def _coarse(log: Measured, channel: MeasuredChannel, good: Array, sensor: Sensor, moving: bool) -> Sequence[DataProblem]:
    """A staircase: the smallest change is much larger than the resolution the rig file declares."""
    step = quantum(channel)
    same = float(np.mean(np.diff(channel.logged) == 0.0)) if channel.logged.size > 1 else 0.0
    if step <= COARSE * sensor.resolution or same < 0.2:
        return []
    declared = f"{sensor.resolution:.3g} {channel.unit}"
    what = f"moves in steps of {step:.3g} {channel.unit}; the rig file declares {declared}. The steps count as noise"
    return [_problem(log, channel, what, False)]


def _problem(log: Measured, channel: MeasuredChannel, what: str, fatal: bool) -> DataProblem:
    return DataProblem(what, channel.name, str(log.path), fatal)
