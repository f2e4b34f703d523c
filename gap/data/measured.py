"""A log as the comparison needs it: a uniform time grid, the commands that acted, and every measured channel the plant has a sensor for."""

from __future__ import annotations

import hashlib
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from config.errors import LogError
from config.schema.rig import Rig
from gap.data.uniform_grid import LEAST_ROWS, UNEVEN, Grid, grid_of
from recording.files.reader import Log, read_log
from recording.format.layout import CycleLayout
from recording.importing.read_table import read_table
from recording.importing.source_columns import columns_by_name

Array = NDArray[np.float64]
Columns = Mapping[str, Array]

_FIELD_UNITS = {"temperature": ("_C", "degC"), "pressure": ("_Pa", "Pa"), "acceleration": ("_mps2", "m/s^2"), "deflection": ("_m", "m")}
_TABLES = (".csv", ".txt", ".tsv", ".mat")


@dataclass(frozen=True, slots=True)
class MeasuredChannel:
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
    channels: Mapping[str, MeasuredChannel]
    missing: NDArray[np.bool_]
    jitter_s: float
    backwards: int
    rig_name: str = ""  # of the rig it was recorded on, as the log says; a table says none
    oil_C: float | None = None  # reservoir at the log's start, where it was measured
    temperatures: Mapping[str, MeasuredChannel] = field(default_factory=dict)  # slower than a window, so compared over whole logs

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
    """Read a whole log as one. LogError for what cannot be used at all."""
    columns, rig_name = columns_of(path, rig)
    return on_grid(path, columns, rig, hashlib.sha256(path.read_bytes()).hexdigest(), rig_name)


def columns_of(path: Path, rig: Rig) -> tuple[Columns, str]:
    """Columns of an MCAP log, or of a table whose columns have the log's names; and the rig that the log was recorded on, where it says."""
    if path.suffix.lower() in _TABLES:
        return _csv_columns(path, rig), ""
    log = read_log(path)
    return log_columns(log, rig), log.metadata.get("recording", {}).get("rig_name", "")


def _csv_columns(path: Path, rig: Rig) -> dict[str, Array]:
    _, columns = columns_by_name(read_table(path), rig)
    return columns


def log_columns(log: Log, rig: Rig) -> dict[str, Array]:
    """Those of a log that is read. LogError for other joints than the rig's."""
    if log.layout.joint_names != tuple(rig.joints):
        names = f"{', '.join(log.layout.joint_names)} instead of {', '.join(rig.joints)}"
        advice = f"Give the rig this log is from: `longreach log info {shlex.quote(str(log.path))}` names it."
        raise LogError("the log has other joints than the rig", value=names, where=str(log.path), next_step=advice)
    return {name: np.asarray(values, dtype=np.float64) for name, values in log.columns.items()}


def on_grid(path: Path, columns: Mapping[str, Array], rig: Rig, sha256: str, rig_name: str = "") -> Measured:
    """Columns of one log on a uniform grid of its median period."""
    t = _times(path, columns)
    grid, logged = grid_of(path, t), columns
    if grid.jitter_s(t) > UNEVEN * grid.period_s:
        columns = _shifted(columns, rig, t, grid)
    commands = np.column_stack([_command(path, columns, rig, joint, grid) for joint in rig.joints])
    found = _channels(columns, logged, rig, grid)
    channels = {name: channel for name, channel in found.items() if "temperature" not in name}
    warm = {name: channel for name, channel in found.items() if "temperature" in name}
    return Measured(
        path=path,
        sha256=sha256,
        t_s=grid.t_s,
        period_s=grid.period_s,
        commands_V=commands,
        channels=channels,
        missing=grid.missing(),
        jitter_s=grid.jitter_s(t),
        backwards=int((np.diff(t) <= 0).sum()),
        rig_name=rig_name,
        oil_C=_oil(columns),
        temperatures=warm,
    )


def _shifted(columns: Mapping[str, Array], rig: Rig, t: Array, grid: Grid) -> dict[str, Array]:
    """Measured columns moved to the instants of the grid by straight lines. A drive's command acts from the row it stands in."""
    drives = {f"{name}.command_V" for name, joint in (rig.plant.joints if rig.plant else {}).items() if not joint.is_imposed}
    moved = dict(columns)
    for name in columns.keys() - drives - {"t_s"}:
        there = grid.keep & np.isfinite(columns[name])
        if there.any():
            moved[name] = columns[name].copy()
            moved[name][there] = np.interp(grid.instants_s[there], t[there], columns[name][there])
    return moved


def _times(path: Path, columns: Mapping[str, Array]) -> Array:
    t = columns.get("t_s")
    if t is None:
        advice = f"`longreach import {shlex.quote(str(path))} --suggest` proposes which column is the time, in s, and which the others are."
        raise LogError("the log has no column t_s", where=str(path), next_step=advice)
    if len(t) < LEAST_ROWS or not np.all(np.isfinite(t)):
        advice = "Log longer, or leave out rows without a time."
        what = "the log is too short or has rows without a time"
        raise LogError(what, value=len(t), limit=LEAST_ROWS, unit="rows", where=str(path), next_step=advice)
    if not np.any(np.diff(t) > 0):
        raise LogError("time does not advance", value=float(t[0]), unit="s", where=f"{path}: t_s", next_step="Check the column t_s.")
    return t


def compared(channels: Iterable[str], rig: Rig) -> list[str]:
    """Of these channels, those the simulation predicts: a motion that is imposed goes into it."""
    imposed = {f"{name}.position" for name, joint in (rig.plant.joints if rig.plant else {}).items() if joint.is_imposed}
    return [name for name in channels if name not in imposed]


def _command(path: Path, columns: Mapping[str, Array], rig: Rig, joint: str, grid: Grid) -> Array:
    name = f"{joint}.command_V"
    if rig.plant and rig.plant.joints[joint].is_imposed and not np.any(np.isfinite(columns.get(name, np.empty(0)))):
        return np.zeros(grid.rows)
    return _held(path, columns, name, grid)


def _held(path: Path, columns: Mapping[str, Array], name: str, grid: Grid) -> Array:
    if name not in columns or not np.any(np.isfinite(columns[name])):
        advice = "The command that acted is the input of every comparison; without it no effect of the drive is identifiable. Log it."
        raise LogError(f"the log has no {name}", where=str(path), next_step=advice)
    values = grid.on(columns[name])
    values[0] = values[np.isfinite(values)][0]
    last = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(grid.rows), 0))
    return values[last]


def _oil(columns: Mapping[str, Array]) -> float | None:
    values = columns.get("reservoir_temperature_C")
    good = values[np.isfinite(values)] if values is not None else np.empty(0)
    return float(np.median(good[:100])) if good.size else None


def _channels(columns: Mapping[str, Array], logged: Mapping[str, Array], rig: Rig, grid: Grid) -> dict[str, MeasuredChannel]:
    """Every fitted signal of the log that the plant has a sensor for."""
    motions = [joint.motion for joint in rig.joints.values()]
    units = {field.name: field.unit for field in CycleLayout(tuple(rig.joints), motions, rig.joints).fields}
    found: dict[str, MeasuredChannel] = {}
    for signal in rig.plant.sensors if rig.plant else ():
        name, _ = field_of(signal)
        if name not in columns or not np.any(np.isfinite(columns[name])):
            continue
        written = logged[name][grid.keep]
        found[signal] = MeasuredChannel(signal, units.get(name, ""), grid.on(columns[name]), written[np.isfinite(written)])
    return found
