"""Can these logs carry a comparison at all? Problems end the search (exit status 3); warnings go into the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from config.errors import LogError
from config.rig import Rig
from gap.measured import Array, Channel, Measured, runs

LEAST_S = 2.0  # a log shorter than this has too few windows to decide anything
LONG_GAP_S = 0.1  # the plant moves on its own in a gap; longer ones are named
STUCK_S = 1.0  # a moving joint's channel that repeats one value for this long
LARGEST_JITTER = 0.3  # of the period
CLIPPED = 0.02  # share of samples at the ends of the sensor's range
CENSORED = 0.2
SAME = 0.999  # correlation of the commands above which two logs are one maneuver
POLARITY = -0.8


@dataclass(frozen=True, slots=True)
class DataProblem:
    """One finding about the data. `fatal`: no verdict about the physics can be given."""

    what: str
    channel: str
    where: str
    fatal: bool

    def text(self) -> str:
        return f"{self.where}: {self.channel + ': ' if self.channel else ''}{self.what}"


def refuse_pairing(fit: Sequence[Measured], holdout: Sequence[Measured]) -> None:
    """The decision needs data that was not fitted. LogError when there is none."""
    if not holdout:
        advice = "Log a second, different maneuver and give it with --holdout: a gap that only closes on the fitted log proves nothing."
        raise LogError("there is no hold-out log", value="one log", limit="two", where=str(fit[0].path), next_step=advice)
    hashes = {log.sha256: log.path for log in fit}
    for log in holdout:
        if log.sha256 in hashes:
            advice = "Give the log of another maneuver."
            raise LogError("the hold-out log is a fit log", value=str(hashes[log.sha256]), where=str(log.path), next_step=advice)


def check(logs: Sequence[Measured], rig: Rig) -> list[DataProblem]:
    """Every problem of every log: excitation, stuck and clipped channels, gaps, jitter, units and joints that cannot be this rig's."""
    found: list[DataProblem] = []
    for log in logs:
        found += _time_problems(log)
        found += _range_problems(log, rig)
        found += _motion_problems(log, rig)
    return found


def same_maneuver(fit: Measured, holdout: Measured) -> bool:
    """Whether two logs have practically the same commands (a repeat tests only the noise)."""
    rows = min(fit.rows, holdout.rows)
    pairs = zip(fit.commands_V[:rows].T, holdout.commands_V[:rows].T, strict=True)
    moved = [(a, b) for a, b in pairs if np.std(a) > 0 and np.std(b) > 0]
    return bool(moved) and all(np.corrcoef(a, b)[0, 1] > SAME for a, b in moved)


def _time_problems(log: Measured) -> list[DataProblem]:
    where, found = str(log.path), []
    if log.duration_s < LEAST_S:
        found.append(DataProblem(f"only {log.duration_s:.2f} s of data; at least {LEAST_S:g} s are needed", "t_s", where, True))
    if log.backwards:
        found.append(DataProblem(f"{log.backwards} rows repeat or go back in time; they are left out", "t_s", where, False))
    for start, length in runs(log.missing):
        if length * log.period_s > LONG_GAP_S:
            what = f"gap of {length * log.period_s:.3f} s from t = {log.t_s[start]:.3f} s; windows there are left out"
            found.append(DataProblem(what, "t_s", where, False))
    if log.jitter_s > LARGEST_JITTER * log.period_s:
        what = f"sampling times are off the grid by up to {1e3 * log.jitter_s:.3g} ms (period {1e3 * log.period_s:.3g} ms)"
        found.append(DataProblem(what, "t_s", where, False))
    return found


def _range_problems(log: Measured, rig: Rig) -> list[DataProblem]:
    where, found = str(log.path), []
    sensors = rig.plant.sensors if rig.plant else {}
    for name, channel in log.channels.items():
        good = channel.values[np.isfinite(channel.values)]
        low, high = sensors[name].low, sensors[name].high
        if np.mean((good < low - 1e-9) | (good > high + 1e-9)) > CLIPPED:
            what = (
                f"runs from {good.min():.6g} to {good.max():.6g} {channel.unit}, but the sensor's range in the rig file is "
                f"{low:.6g} to {high:.6g}: wrong unit, swapped channel or another rig"
            )
            found.append(DataProblem(what, name, where, True))
        elif censored(channel, low, high):
            what = "more than a fifth of the samples stand at the end of the sensor's range, where noise is cut off: not compared"
            found.append(DataProblem(what, name, where, False))
        elif np.mean((good <= low) | (good >= high)) > CLIPPED:
            found.append(DataProblem("more than 2% of the samples stand at the end of the sensor's range", name, where, False))
    return found


def censored(channel: Channel, low: float, high: float) -> bool:
    """Whether the end of the range cuts off so much that the channel's noise is no noise any more."""
    good = channel.values[np.isfinite(channel.values)]
    return bool(np.mean((good <= low) | (good >= high)) > CENSORED)


def _motion_problems(log: Measured, rig: Rig) -> list[DataProblem]:
    where, found, moved = str(log.path), [], False
    for number, joint in enumerate(rig.joints):
        channel = log.channels.get(f"{joint}.position")
        if channel is None:
            found.append(DataProblem("is not in the log; every joint's position is needed", f"{joint}.position", where, True))
            continue
        commands = log.commands_V[:, number]
        moves = _moves(channel)
        moved = moved or moves
        if _is_imposed(rig, joint):
            continue
        if not moves and np.ptp(commands) > 0.2 * _full_scale(rig, joint):
            what = f"does not change although {joint}.command_V spans {np.ptp(commands):.3g} V: stuck channel or locked joint"
            found.append(DataProblem(what, channel.name, where, True))
        elif moves:
            found += _stuck(log, channel, commands, 0.2 * _full_scale(rig, joint))
            found += _wrong_way(log, channel, commands)
            found += _outside_travel(log, channel, rig, joint)
    if not moved and not any(problem.fatal for problem in found):
        what = "no joint moves: nothing can be learned about the plant from this log; run a maneuver that moves it"
        found.append(DataProblem(what, "", where, True))
    return found


def _moves(channel: Channel) -> bool:
    good = channel.values[np.isfinite(channel.values)]
    step = quantum(channel)
    return bool(np.ptp(good) > max(20 * step, 1e-9))


def quantum(channel: Channel) -> float:
    """The smallest change of a channel: its quantisation, as far as the data show it."""
    good = channel.values[np.isfinite(channel.values)]
    changes = np.abs(np.diff(good))
    changes = changes[changes > 1e-12 * max(float(np.ptp(good)), 1e-30)]
    return float(np.quantile(changes, 0.02)) if changes.size > 10 else 0.0


def _stuck(log: Measured, channel: Channel, commands: Array, threshold: float) -> list[DataProblem]:
    """One exact value for long while the command asks for motion."""
    still = np.concatenate([[False], np.diff(channel.values) == 0.0])
    for start, length in runs(still):
        span = commands[start : start + length]
        if length * log.period_s > STUCK_S and np.abs(np.median(span)) > threshold:
            what = f"stands at exactly {channel.values[start]:.6g} for {length * log.period_s:.2f} s from t = {log.t_s[start]:.3f} s"
            return [DataProblem(f"{what} while the command asks for motion: stuck channel", channel.name, str(log.path), True)]
    return []


def _wrong_way(log: Measured, channel: Channel, commands: Array) -> list[DataProblem]:
    """Mean velocity over half a second against mean command: a clear negative slope is a sign or wiring error."""
    rows = max(round(0.5 / log.period_s), 2)
    count = log.rows // rows
    blocks = channel.values[: count * rows : rows]
    velocity = np.diff(blocks)
    drive = commands[: count * rows].reshape(count, rows).mean(axis=1)[:-1]
    good = np.isfinite(velocity)
    if good.sum() < 6 or np.std(drive[good]) == 0 or np.std(velocity[good]) == 0:
        return []
    correlation = float(np.corrcoef(drive[good], velocity[good])[0, 1])
    if correlation > POLARITY:
        return []
    what = f"moves against its command (correlation {correlation:.2f}): sign of the sensor or of the command"
    return [DataProblem(what, channel.name, str(log.path), False)]


def _outside_travel(log: Measured, channel: Channel, rig: Rig, joint: str) -> list[DataProblem]:
    assert rig.plant is not None
    low, high = rig.plant.joints[joint].travel
    good = channel.values[np.isfinite(channel.values)]
    slack = 0.02 * (high - low)
    if np.mean((good < low - slack) | (good > high + slack)) <= CLIPPED:
        return []
    limits = f"but the joint's travel is {low:.6g} to {high:.6g}: wrong unit, swapped joints or another rig"
    what = f"runs from {good.min():.6g} to {good.max():.6g}, {limits}"
    return [DataProblem(what, channel.name, str(log.path), True)]


def _is_imposed(rig: Rig, joint: str) -> bool:
    return rig.plant is not None and rig.plant.joints[joint].is_imposed


def _full_scale(rig: Rig, joint: str) -> float:
    assert rig.plant is not None
    plant: Any = rig.plant.joints[joint]
    return float(plant.valve.full_scale_V if hasattr(plant, "valve") else plant.full_scale_V)
