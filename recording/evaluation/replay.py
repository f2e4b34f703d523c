"""Re-executes the controller from a log alone and compares every output bit for bit; or with a change, and says what it makes.

The controller is a pure function of its state, the rig file and the inputs of each cycle, and all three are in the log. With a
change the measured positions are still those of the log: the answer is what this controller would have asked, not what the arm
would have done.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from config.errors import LogError
from config.loading.load import changed_rig
from config.schema.rig import Rig
from recording.files.info import require_cycles
from recording.files.reader import Log, read_log
from recording.files.recordings import asked
from recording.format.fields import CONTROLLER_FIELDS, TIP_CORRECTION, field_of_signal
from servo_control.controller import Controller
from servo_control.planning.run_request import RunRequest
from servo_control.servo.oil_compensation import temperature_signals
from servo_control.signals import Inputs, Outputs
from servo_control.streaming.any_plan import plan_any

Values = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Divergence:
    """The first value that came out differently."""

    cycle: int
    t_s: float
    signal: str
    logged: float
    replayed: float

    def text(self) -> str:
        logged, replayed = (f"{value!r} ({float(value).hex()})" for value in (self.logged, self.replayed))
        return f"first difference at cycle {self.cycle}, t = {self.t_s:.6f} s: {self.signal} is {logged} in the log, {replayed} re-executed"


@dataclass(frozen=True, slots=True)
class Difference:
    """How much one signal changed over the whole log, in its own unit."""

    signal: str
    unit: str
    rms: float
    largest: float


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """`cycles` were re-executed; `identical`: all that the log holds, without a difference. `note` says why it ended before the end of the
    log, and what else a reader should know."""

    identical: bool
    cycles: int
    first: Divergence | None
    overrides: tuple[str, ...]
    differences: tuple[Difference, ...]
    note: str

    def text(self) -> str:
        if self.overrides:
            return self._what_if()
        alike = "bit-identical" if self.identical else "not re-executed as a whole: identical up to a gap"
        head = f"{alike}, {self.cycles} cycles" if self.first is None else self.first.text()
        return f"{head}. {self.note}" if self.note else head

    def _what_if(self) -> str:
        head = f"{self.cycles} cycles with {', '.join(self.overrides)} and the positions of the log:"
        changed = [f"  {d.signal:24}{d.unit:8}rms {d.rms:.6g}, largest {d.largest:.6g}" for d in self.differences if d.largest > 0]
        return "\n".join([head, *(changed or ["  nothing changes"]), *([self.note] if self.note else [])])


def reexecute(path: str | Path, overrides: Sequence[str] = ()) -> ReplayResult:
    """Run the log's controller again. `overrides` change the rig file, e.g. "servo.rotary.gain=0.5 V/deg".

    Raises LogError when the log cannot be re-executed, ConfigError for an override that does not fit.
    """
    log = read_log(path)
    rig = _rig(log, overrides)
    end, note = _contiguous(log)
    replayed = _run(log, rig, end)
    logged = {name: np.asarray(log.columns[name][:end], dtype=np.float64) for name in replayed}
    first = _first_divergence(log, logged, replayed)
    if first is not None and not overrides:
        note = f"{note} {_version_note(log)}".strip()
    if not log.complete:
        note = f"{note} {log.cut_text}".strip()
    units = {field.name: field.unit for field in log.layout.fields}
    differences = tuple(_difference(name, units[name], logged[name], replayed[name]) for name in replayed)
    whole = first is None and end == log.cycles
    return ReplayResult(whole, end, first, tuple(overrides), differences if overrides else (), note)


def _rig(log: Log, overrides: Sequence[str]) -> Rig:
    if log.kind == "imported":
        advice = "Only logs that longreach recorded can be re-executed; plot, check and gap work on imported data."
        raise LogError("imported data have no controller to re-execute", where=str(log.path), next_step=advice)
    for name in ("rig.yaml", "controller_state.json"):
        if name not in log.attachments:
            raise _lacks(log, name)
    text = log.attachments["rig.yaml"].decode()
    return changed_rig(text, f"{log.path.name}:rig.yaml", overrides).rig


def _lacks(log: Log, name: str) -> LogError:
    return LogError(f"the log lacks {name}, which re-execution needs", where=str(log.path), next_step=_says_more(log))


def _contiguous(log: Log) -> tuple[int, str]:
    """How many rows follow each other without a missing cycle; after one the controller's state is not known."""
    gaps = np.flatnonzero(np.diff(log.columns["cycle"].astype(np.int64)) != 1)
    if not len(gaps):
        return log.cycles, ""
    before, after = log.columns["cycle"][gaps[0]], log.columns["cycle"][gaps[0] + 1]
    return int(gaps[0]) + 1, f"The log lacks the cycles between {before} and {after}, so re-execution ends there."


def controller_state_before(log: Log, row: int) -> dict[str, Any]:
    """What a log that begins with this row needs to be executed again: the state after all rows before it.

    LogError where the log cannot be executed again, or lacks cycles before that row.
    """
    rig = _rig(log, ())
    end, note = _contiguous(log)
    if row > end:
        raise LogError(note, where=str(log.path), next_step="Only what is before can be executed again.")
    controller = Controller(rig)
    deque(_steps(controller, log, rig, row), maxlen=0)
    return controller.snapshot()


def _run(log: Log, rig: Rig, end: int) -> dict[str, Values]:
    """Every controller output of the first `end` rows, by column name."""
    joints = log.layout.joint_names
    names = ["segment", TIP_CORRECTION, *(f"{joint}.{name}" for joint in joints for name in CONTROLLER_FIELDS)]
    rows: list[list[float]] = []
    for outputs in _steps(Controller(rig), log, rig, end):
        of_joints = (getattr(joint, name) for joint in outputs.joints for name in CONTROLLER_FIELDS)
        rows.append([outputs.segment, outputs.tip_correction_rad, *of_joints])
    table = np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
    return {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(names) if log.layout.has(name)}


def _steps(controller: Controller, log: Log, rig: Rig, end: int) -> Iterator[Outputs]:
    """The controller through the first `end` rows, from its state before them."""
    _require_first_cycle(log)
    _restore(controller, log)
    prepared = 0
    for inputs in _inputs(log, rig, end):
        if inputs.run and inputs.run != prepared:
            controller.prepare(plan_any(rig, _request(log, inputs.run)))
            prepared = inputs.run
        yield controller.step(inputs)


def _require_first_cycle(log: Log) -> None:
    """The controller's state in the log is that before the first cycle of the recording."""
    require_cycles(log, "to re-execute")
    first, begun = int(log.columns["cycle"][0]), log.begun_cycle
    if begun not in (None, first):
        what = "the log lacks its first cycles, and the controller's state is only known before these"
        value, advice = f"it begins with cycle {first}", _says_more(log)
        raise LogError(what, value=value, limit=f"cycle {begun}", where=str(log.path), next_step=advice)


def _says_more(log: Log) -> str:
    return f"{asked('check', log.path)} says what is in it."


def _restore(controller: Controller, log: Log) -> None:
    try:
        controller.restore(json.loads(log.attachments["controller_state.json"]))
    except (KeyError, ValueError, TypeError, IndexError) as error:
        what = "the controller state in the log does not fit its rig file"
        advice = "A change may alter values of the rig file, not its structure."
        raise LogError(what, value=str(error), where=str(log.path), next_step=advice) from error


def _inputs(log: Log, rig: Rig, end: int) -> list[Inputs]:
    """The inputs of every cycle as plain Python values."""
    names = ["cycle", "mode", "maneuver", "tip.deflection_m", "tip.acceleration_mps2"]
    names += [f"{joint}.position" for joint in log.layout.joint_names]
    columns = [log.columns[name][:end].tolist() for name in names]
    points = {stamped.cycle: stamped.point for stamped in log.set_points}
    return [
        Inputs(cycle, mode, run, tuple(position), deflection, acceleration, oil, points.get(cycle))
        for oil, (cycle, mode, run, deflection, acceleration, *position) in zip(
            _oil_temperatures(log, rig, end), zip(*columns, strict=True), strict=True
        )
    ]


def _oil_temperatures(log: Log, rig: Rig, end: int) -> Iterable[tuple[float, ...]]:
    """What the oil compensation of every joint was given; empty tuples on a rig without."""
    signals = temperature_signals(rig)
    if not any(signals):
        return [()] * end
    lost = [nan] * end
    return zip(*(log.columns[field_of_signal(name)][:end].tolist() if name else lost for name in signals), strict=True)


def _request(log: Log, run: int) -> RunRequest:
    name = f"run-{run}.json"
    if name not in log.attachments:
        raise _lacks(log, name)
    return RunRequest.from_json(log.attachments[name])


def _first_divergence(log: Log, logged: dict[str, Values], replayed: dict[str, Values]) -> Divergence | None:
    """By the bits of the numbers: 0.0 and -0.0 differ, two NaN do not."""
    rows = {name: _first_unequal(logged[name], replayed[name]) for name in replayed}
    found = {name: row for name, row in rows.items() if row is not None}
    if not found:
        return None
    name = min(found, key=lambda key: found[key])
    row = found[name]
    cycle, t_s = int(log.columns["cycle"][row]), float(log.columns["t_s"][row])
    return Divergence(cycle, t_s, name, float(logged[name][row]), float(replayed[name][row]))


def _first_unequal(left: Values, right: Values) -> int | None:
    unequal = (left.view(np.uint64) != right.view(np.uint64)) & ~(np.isnan(left) & np.isnan(right))
    return int(np.argmax(unequal)) if unequal.any() else None


def _difference(name: str, unit: str, logged: Values, replayed: Values) -> Difference:
    change = np.nan_to_num(replayed - logged)
    return Difference(name, unit, float(np.sqrt(np.mean(change**2))) if len(change) else 0.0, float(np.max(np.abs(change), initial=0.0)))


def _version_note(log: Log) -> str:
    written, here = log.metadata.get("recording", {}).get("software_version", "unknown"), version("longreach")
    return f"The log was written by version {written}, this is {here}." if written != here else ""
