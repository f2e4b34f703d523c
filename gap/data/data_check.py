"""Can these logs carry a comparison at all? Problems end the search (exit status 3); warnings go into the report."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import Any

import numpy as np

from config.checking.actuator_sizes import actuator_sizes
from config.errors import LogError
from config.schema.rig import Rig
from gap.data.channel_check import CLIPPED, DataProblem, channel_problems, log_moves, moves, quantum
from gap.data.measured import Array, Measured, MeasuredChannel
from gap.data.uniform_grid import runs

__all__ = ["DataProblem", "check", "quantum", "refuse_pairing", "same_maneuver"]

LONG_GAP_S = 0.1  # the plant moves on its own in a gap; longer ones are named
STUCK_S = 1.0  # a moving joint's channel that repeats one value for this long
LARGEST_JITTER = 0.3  # of the period
SAME = 0.999  # correlation of commands of one size above which two logs are one maneuver
POLARITY = -0.8
CROSSED = 0.8  # correlation of a joint's rate with another joint's command …
UNMOVED = 0.4  # … while its own says so little
_BLOCK_S = 0.5
SLOWEST = 100.0  # times slower than its command asks for: no leak and no wear does that to a joint that moves
_OPEN = 0.02  # of the rows, with a command that opens the valve well, from which something is said of speeds


def refuse_pairing(fit: Sequence[Measured], holdout: Sequence[Measured]) -> None:
    """The decision needs data that was not fitted. LogError when there is none."""
    if not holdout:
        advice = (
            "Log a second, different maneuver and give it with --holdout: a gap that only closes on the fitted log proves nothing. "
            f"{_others(fit[0])}"
        )
        raise LogError("there is no hold-out log", value="one log", limit="two", where=str(fit[0].path), next_step=advice)
    for log in holdout:
        for other in fit:
            if _same_file(log, other) or _same_numbers(log, other):
                advice = f"Give the log of another maneuver. {_others(log)}"
                raise LogError("the hold-out log is a fit log", value=str(other.path), where=str(log.path), next_step=advice)


def _others(log: Measured) -> str:
    return f"`longreach runs {shlex.quote(str(log.path.parent))}` lists what there is."


def _same_file(a: Measured, b: Measured) -> bool:
    """Parts of one file that overlap in time."""
    return a.sha256 == b.sha256 and a.t_s[0] < b.t_s[-1] and b.t_s[0] < a.t_s[-1]


def _same_numbers(a: Measured, b: Measured) -> bool:
    """The same measurement under another name or in another format."""
    if a.rows != b.rows or set(a.channels) != set(b.channels) or not np.array_equal(a.commands_V, b.commands_V):
        return False
    return all(np.array_equal(a.channels[name].values, b.channels[name].values, equal_nan=True) for name in a.channels)


def check(logs: Sequence[Measured], rig: Rig) -> list[DataProblem]:
    """Every problem of every log: excitation, stuck, clipped and dead channels, gaps, jitter, units and joints not of this rig."""
    found: list[DataProblem] = []
    sensors = rig.plant.sensors if rig.plant else {}
    for log in logs:
        if log.rig_name not in ("", rig.name):
            what = f"was recorded on the rig {log.rig_name}, and the model is {rig.name}"
            found.append(DataProblem(what, "", str(log.path), False))
        found += _time_problems(log)
        moving = log_moves(log)
        for name, channel in log.channels.items():
            found += channel_problems(log, channel, sensors[name], moving)
        found += _motion_problems(log, rig)
        found += _crossed_commands(log, rig)
    return found


def same_maneuver(fit: Measured, holdout: Measured) -> bool:
    """Whether two logs have practically the same commands (a repeat tests only the noise). 1 V is another maneuver than 2 V: what counts
    is the difference of the commands, apart from a constant; for two of one size it is their correlation, 2 (1 − ρ) of the variance."""
    rows = min(fit.rows, holdout.rows)
    pairs = zip(fit.commands_V[:rows].T, holdout.commands_V[:rows].T, strict=True)
    moved = [(a, b) for a, b in pairs if np.std(a) > 0 and np.std(b) > 0]
    return bool(moved) and all(np.var(a - b) < 2.0 * (1.0 - SAME) * np.std(a) * np.std(b) for a, b in moved)


def _time_problems(log: Measured) -> list[DataProblem]:
    where, found = str(log.path), []
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


def _motion_problems(log: Measured, rig: Rig) -> list[DataProblem]:
    where, found, moved = str(log.path), [], False
    for number, joint in enumerate(rig.joints):
        channel = log.channels.get(f"{joint}.position")
        if channel is None:
            found.append(DataProblem("is not in the log; every joint's position is needed", f"{joint}.position", where, True))
            continue
        moving = moves(channel)
        moved = moved or moving
        if not _is_imposed(rig, joint):
            found += _against_command(log, rig, joint, channel, log.commands_V[:, number], moving)
    if not moved and not any(problem.fatal for problem in found):
        what = "no joint moves: nothing can be learned about the plant from this log; run a maneuver that moves it"
        found.append(DataProblem(what, "", where, True))
    return found


def _against_command(log: Measured, rig: Rig, joint: str, channel: MeasuredChannel, commands: Array, moving: bool) -> list[DataProblem]:
    """A driven joint's position beside what was asked of it."""
    threshold = 0.2 * _full_scale(rig, joint)
    if moving:
        found = [
            *_stuck(log, channel, commands, threshold),
            *_wrong_way(log, channel, commands),
            *_outside_travel(log, channel, rig, joint),
        ]
        return found or _too_slow(log, channel, commands, rig, joint)
    if np.ptp(commands) <= threshold:
        return []
    what = f"does not change although {joint}.command_V spans {np.ptp(commands):.3g} V: stuck channel or locked joint"
    return [DataProblem(what, channel.name, str(log.path), True)]


def _stuck(log: Measured, channel: MeasuredChannel, commands: Array, threshold: float) -> list[DataProblem]:
    """One exact value for long while the command asks for motion."""
    still = np.concatenate([[False], np.diff(channel.values) == 0.0])
    for start, length in runs(still):
        span = commands[start : start + length]
        if length * log.period_s > STUCK_S and np.abs(np.median(span)) > threshold:
            when = f"for {length * log.period_s:.2f} s from t = {log.t_s[start]:.3f} s"
            what = f"stands at exactly {channel.values[start]:.6g} {channel.unit} {when}"
            return [DataProblem(f"{what} while the command asks for motion: stuck channel", channel.name, str(log.path), True)]
    return []


def _wrong_way(log: Measured, channel: MeasuredChannel, commands: Array) -> list[DataProblem]:
    """Mean velocity against mean command: a clear negative slope is a sign or wiring error."""
    correlation = _rate_with_command(log, channel, commands)
    if correlation > POLARITY:
        return []
    what = f"moves against its command (correlation {correlation:.2f}): sign of the sensor or of the command"
    return [DataProblem(what, channel.name, str(log.path), False)]


def _too_slow(log: Measured, channel: MeasuredChannel, commands: Array, rig: Rig, joint: str) -> list[DataProblem]:
    """A valve that is open turns or moves its joint at some share of its full speed; a hundredth of that is a time in ms read as s."""
    sizes = actuator_sizes(rig, joint)
    open_rows = np.abs(commands) > 0.2 * _full_scale(rig, joint)
    if sizes is None or np.mean(open_rows) < _OPEN:
        return []
    rates = np.abs(np.gradient(channel.values, log.t_s))[open_rows]
    fastest, asked = (
        float(np.nanquantile(rates, 0.9)),
        sizes.full_speed * float(np.median(np.abs(commands[open_rows]))) / sizes.full_scale_V,
    )
    if fastest * SLOWEST > asked:
        return []
    what = f"moves at {fastest:.3g} {channel.unit}/s at most where its command asks for {asked:.3g}: are the times in ms?"
    return [DataProblem(what, channel.name, str(log.path), True)]


def _rate_with_command(log: Measured, channel: MeasuredChannel, commands: Array) -> float:
    """Correlation of mean velocity and mean command over blocks of half a second; 0 where nothing can be said."""
    rows = max(round(_BLOCK_S / log.period_s), 2)
    count = log.rows // rows
    velocity = np.diff(channel.values[: count * rows : rows])
    drive = commands[: count * rows].reshape(count, rows).mean(axis=1)[:-1]
    good = np.isfinite(velocity)
    if good.sum() < 6 or np.std(drive[good]) == 0 or np.std(velocity[good]) == 0:
        return 0.0
    return float(np.corrcoef(drive[good], velocity[good])[0, 1])


def _crossed_commands(log: Measured, rig: Rig) -> list[DataProblem]:
    """Two joints that follow each other's command: columns swapped."""
    joints = list(rig.joints)
    if len(joints) != 2 or any(_is_imposed(rig, joint) or f"{joint}.position" not in log.channels for joint in joints):
        return []
    found = np.array([[_rate_with_command(log, log.channels[f"{a}.position"], log.commands_V[:, k]) for k in (0, 1)] for a in joints])
    if not (np.abs(found[[0, 1], [1, 0]]).min() > CROSSED and np.abs(found[[0, 1], [0, 1]]).max() < UNMOVED):
        return []
    follow = f"{joints[0]} follows {joints[1]}.command_V (correlation {found[0, 1]:.2f}) and the other way round"
    return [DataProblem(f"{follow}: swapped columns", f"{joints[0]}.command_V", str(log.path), True)]


def _outside_travel(log: Measured, channel: MeasuredChannel, rig: Rig, joint: str) -> list[DataProblem]:
    assert rig.plant is not None
    low, high = rig.plant.joints[joint].travel
    good = channel.values[np.isfinite(channel.values)]
    slack = 0.02 * (high - low)
    if np.mean((good < low - slack) | (good > high + slack)) <= CLIPPED:
        return []
    limits = f"but the joint's travel is {low:.6g} to {high:.6g} {channel.unit}: wrong unit, swapped joints or another rig"
    what = f"runs from {good.min():.6g} to {good.max():.6g} {channel.unit}, {limits}"
    return [DataProblem(what, channel.name, str(log.path), True)]


def _is_imposed(rig: Rig, joint: str) -> bool:
    return rig.plant is not None and rig.plant.joints[joint].is_imposed


def _full_scale(rig: Rig, joint: str) -> float:
    assert rig.plant is not None
    plant: Any = rig.plant.joints[joint]
    return float(plant.valve.full_scale_V if hasattr(plant, "valve") else plant.full_scale_V)
