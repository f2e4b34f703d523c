"""A log as the comparison needs it: a uniform time grid, the commands that acted, and every measured channel the plant has a sensor for."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from config.errors import LogError
from config.rig import Rig
from recording.layout import CycleLayout
from recording.reader import read_log
from recording.source_columns import columns_by_name
from recording.table import read_table

Array = NDArray[np.float64]

_FIELD_UNITS = {"temperature": ("_C", "degC"), "pressure": ("_Pa", "Pa"), "acceleration": ("_mps2", "m/s^2"), "deflection": ("_m", "m")}
_TABLES = (".csv", ".txt", ".tsv")
BRIDGED_ROWS = 3  # lost rows in a row over which a straight line is drawn; the plant moves on its own in longer gaps
SHORTEST_PERIOD_S = 1e-4
UNEVEN = 0.05  # of the period: samples further off the grid are moved onto it
MOST_MISSING = 0.5  # share of the grid without a row, above which the rate itself is in doubt


@dataclass(frozen=True, slots=True)
class Channel:
    """One measured signal: values on the grid (NaN where there is none), and what was `logged`, without what is missing: a value moved
    onto the grid lies between two steps of the reading, a logged one on a step."""

    name: str
    unit: str
    values: Array
    logged: Array


@dataclass(frozen=True, slots=True)
class Measured:
    """One log. `commands_V`: rows × joints (order of rig.joints), held over missing rows; the grid `t_s` starts at the log's first time.

    `missing` marks rows of the grid in gaps too long to bridge; rows lost singly have no value in `channels` (they are not compared).
    A joint whose motion is imposed needs no command (0 then).
    """

    path: Path
    sha256: str
    t_s: Array
    period_s: float
    commands_V: Array
    channels: Mapping[str, Channel]
    missing: NDArray[np.bool_]
    jitter_s: float
    backwards: int
    oil_C: float | None = None  # reservoir at the log's start, where it was measured
    temperatures: Mapping[str, Channel] = field(default_factory=dict)  # slower than a window, so compared over whole logs

    @property
    def rows(self) -> int:
        return len(self.t_s)

    @property
    def duration_s(self) -> float:
        return self.rows * self.period_s


def field_of(signal: str) -> tuple[str, str]:
    """Column of a log and unit of a signal: `rotary.supply_pressure` → (`rotary.supply_pressure_Pa`, `Pa`)."""
    for word, (suffix, unit) in _FIELD_UNITS.items():
        if word in signal:
            return signal + suffix, unit
    return signal, ""


def load(path: Path, rig: Rig) -> Measured:
    """Read an MCAP log, or a CSV whose columns have the contract's names. LogError for what cannot be used at all."""
    columns = _csv_columns(path, rig) if path.suffix.lower() in _TABLES else _log_columns(path, rig)
    return on_grid(path, columns, rig, hashlib.sha256(path.read_bytes()).hexdigest())


def _csv_columns(path: Path, rig: Rig) -> dict[str, Array]:
    _, columns = columns_by_name(read_table(path), rig)
    return columns


def _log_columns(path: Path, rig: Rig) -> dict[str, Array]:
    log = read_log(path)
    if log.layout.joint_names != tuple(rig.joints):
        names = f"{', '.join(log.layout.joint_names)} instead of {', '.join(rig.joints)}"
        raise LogError("the log has other joints than the rig", value=names, where=str(path), next_step="Give the rig this log is from.")
    return {name: np.asarray(values, dtype=np.float64) for name, values in log.columns.items()}


def on_grid(path: Path, columns: Mapping[str, Array], rig: Rig, sha256: str) -> Measured:
    """Columns of one log on a uniform grid of its median period."""
    t = _times(path, columns)
    steps = np.diff(t)
    period = _period(t)
    if period < SHORTEST_PERIOD_S * (1 - UNEVEN):
        advice = "Keep every second (third …) row: the simulation's delay lines hold 0.1 s at up to 10 kHz."
        raise LogError("the log is sampled too fast", value=round(1 / period), limit=10_000, unit="Hz", where=str(path), next_step=advice)
    index = np.round((t - t[0]) / period).astype(np.int64)
    keep = np.concatenate([[True], np.diff(np.maximum.accumulate(index)) > 0])
    rows = int(index[keep][-1]) + 1
    if keep.sum() < (1 - MOST_MISSING) * rows:
        lost = f"{1 - keep.sum() / rows:.0%} of the rows"
        raise LogError(
            "the log has no steady rate", value=lost, limit="50%", where=str(path), next_step="Give data with one sampling rate."
        )
    place = index[keep]
    missing = np.ones(rows, dtype=np.bool_)
    missing[place] = False
    for start, length in runs(missing):
        missing[start : start + length] = length > BRIDGED_ROWS
    jitter = float(np.max(np.abs((t - t[0] - index * period)[keep])))
    logged = columns
    if jitter > UNEVEN * period:
        columns = _shifted(columns, rig, t, t[0] + index * period, keep)
    commands = np.column_stack([_command(path, columns, rig, joint, keep, place, rows) for joint in rig.joints])
    grid: Array = float(t[0]) + period * np.arange(rows, dtype=np.float64)
    found = _channels(columns, logged, rig, keep, place, rows)
    channels = {name: channel for name, channel in found.items() if "temperature" not in name}
    warm = {name: channel for name, channel in found.items() if "temperature" in name}
    return Measured(path, sha256, grid, period, commands, channels, missing, jitter, int((steps <= 0).sum()), _oil(columns), warm)


def _shifted(columns: Mapping[str, Array], rig: Rig, t: Array, grid: Array, keep: NDArray[np.bool_]) -> dict[str, Array]:
    """Measured columns moved to the instants of the grid by straight lines. A drive's command acts from the row it stands in."""
    drives = {f"{name}.command_V" for name, joint in (rig.plant.joints if rig.plant else {}).items() if not joint.is_imposed}
    moved = dict(columns)
    for name in columns.keys() - drives - {"t_s"}:
        there = keep & np.isfinite(columns[name])
        if there.any():
            moved[name] = columns[name].copy()
            moved[name][there] = np.interp(grid[there], t[there], columns[name][there])
    return moved


def _times(path: Path, columns: Mapping[str, Array]) -> Array:
    t = columns.get("t_s")
    if t is None:
        raise LogError("the log has no column t_s", where=str(path), next_step="Give the time of every row in seconds as t_s.")
    if len(t) < 200 or not np.all(np.isfinite(t)):
        raise LogError("the log is too short or has rows without a time", value=len(t), limit=200, unit="rows", where=str(path))
    if not np.any(np.diff(t) > 0):
        raise LogError("time does not advance", value=float(t[0]), unit="s", where=f"{path}: t_s", next_step="Check the column t_s.")
    return t


def _period(t: Array) -> float:
    """Mean period of the rows. The median step alone is off by its own jitter, which adds up over a log; a line through row number and
    time is not."""
    steps = np.diff(t)
    guess = float(np.median(steps[steps > 0]))
    number = np.concatenate([[0.0], np.cumsum(np.round(np.maximum(steps, 0.0) / guess))])
    return float(np.polyfit(number - number.mean(), t - t.mean(), 1)[0])


def compared(channels: Iterable[str], rig: Rig) -> list[str]:
    """Of these channels, those the simulation predicts: a motion that is imposed goes into it."""
    imposed = {f"{name}.position" for name, joint in (rig.plant.joints if rig.plant else {}).items() if joint.is_imposed}
    return [name for name in channels if name not in imposed]


def _command(
    path: Path, columns: Mapping[str, Array], rig: Rig, joint: str, keep: NDArray[np.bool_], place: NDArray[np.int64], rows: int
) -> Array:
    name = f"{joint}.command_V"
    if rig.plant and rig.plant.joints[joint].is_imposed and not np.any(np.isfinite(columns.get(name, np.empty(0)))):
        return np.zeros(rows)
    return _held(path, columns, name, keep, place, rows)


def _held(path: Path, columns: Mapping[str, Array], name: str, keep: NDArray[np.bool_], place: NDArray[np.int64], rows: int) -> Array:
    if name not in columns or not np.any(np.isfinite(columns[name])):
        advice = "The command that acted is the input of every comparison; without it no effect of the drive is identifiable. Log it."
        raise LogError(f"the log has no {name}", where=str(path), next_step=advice)
    values = np.full(rows, np.nan)
    values[place] = columns[name][keep]
    values[0] = values[np.isfinite(values)][0]
    last = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(rows), 0))
    return values[last]


def bridged(values: Array) -> Array:
    """Values with a straight line over at most BRIDGED_ROWS lost ones; NaN stays in longer gaps."""
    lost = np.isnan(values)
    rows = np.arange(len(values))
    filled = np.interp(rows, rows[~lost], values[~lost]) if not lost.all() else values.copy()
    for start, length in runs(lost):
        if length > BRIDGED_ROWS:
            filled[start : start + length] = np.nan
    return np.asarray(filled)


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Start and length of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(start), int(end - start)) for start, end in zip(edges[::2], edges[1::2], strict=True)]


def _oil(columns: Mapping[str, Array]) -> float | None:
    values = columns.get("reservoir_temperature_C")
    good = values[np.isfinite(values)] if values is not None else np.empty(0)
    return float(np.median(good[:100])) if good.size else None


def _channels(
    columns: Mapping[str, Array], logged: Mapping[str, Array], rig: Rig, keep: NDArray[np.bool_], place: NDArray[np.int64], rows: int
) -> dict[str, Channel]:
    """Every fitted signal of the log that the plant has a sensor for."""
    motions = [joint.motion for joint in rig.joints.values()]
    units = {field.name: field.unit for field in CycleLayout(tuple(rig.joints), motions, rig.joints).fields}
    found: dict[str, Channel] = {}
    for signal in rig.plant.sensors if rig.plant else ():
        name, _ = field_of(signal)
        if name not in columns or not np.any(np.isfinite(columns[name])):
            continue
        values = np.full(rows, np.nan)
        values[place] = columns[name][keep]
        written = logged[name][keep]
        found[signal] = Channel(signal, units.get(name, ""), values, written[np.isfinite(written)])
    return found
