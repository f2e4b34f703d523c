"""The excited part of a sweep or multisine run, out of a log: what was put in, what the joint was commanded, where it went."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np

from config.errors import LogError
from recording.evaluation.spectrum import without_gaps
from recording.files.reader import Column, Log, open_rig
from servo_control.path.joint_limits import joint_index, joint_limits
from servo_control.planning.planning import plan_run
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Mode
from tuning.arrays import Floats

KINDS = ("sine_sweep", "multisine")


@dataclass(frozen=True, slots=True)
class ResponseConditions:
    """Under which a response holds. Amplitude as in the maneuver (V on the command, rad or m on the reference); `position`: where a single
    axis stood (rad or m). NaN: not measured, or not of such a rig."""

    joint: str
    on: str
    amplitude: float
    extension_m: float
    oil_C: float
    payload_kg: float
    position: float = nan


@dataclass(frozen=True, slots=True)
class ExcitedRun:
    """One value a period: excitation (unit of the amplitude), command (V), position (rad or m). `maneuver` as in the run's request."""

    run: int
    conditions: ResponseConditions
    maneuver: dict[str, Any]
    period_s: float
    excitation: Floats
    command: Floats
    position: Floats


def excited_runs(log: Log) -> list[ExcitedRun]:
    """Every whole sweep and multisine of a log. LogError when there is none, or cycles are missing inside one."""
    found = []
    for run in (int(n) for n in np.unique(log.columns["maneuver"]) if n):
        request = RunRequest.from_json(log.attachments[f"run-{run}.json"]) if f"run-{run}.json" in log.attachments else None
        rows = np.flatnonzero((log.columns["maneuver"] == run) & (log.columns["mode"] == Mode.RUNNING))
        if request is not None and request.maneuver["kind"] in KINDS and len(rows):
            found.append(_excited(log, run, request, rows))
    if not found:
        raise LogError("no sweep or multisine in the log", where=str(log.path), next_step="Record one with `longreach identify`.")
    return found


def _excited(log: Log, run: int, request: RunRequest, rows: Column) -> ExcitedRun:
    rig = open_rig(log)
    plan = plan_run(rig, request)
    period_s = 1.0 / rig.loop.rate_Hz
    number = next(n for n, piece in enumerate(plan.program.pieces) if piece.name in ("sweep", "multisine"))
    segment = plan.segments[number]
    first, count = round(segment.start_s / period_s), round((segment.end_s - segment.start_s) / period_s)
    part = rows[first : first + count]
    if len(part) < count or part[-1] - part[0] != count - 1 or np.any(np.diff(log.columns["cycle"][part].astype(np.int64)) != 1):
        raise LogError("the excitation is not whole in the log", value=f"{len(part)} of {count} cycles", where=f"{log.path}, run {run}")
    j = joint_index(joint_limits(rig), str(request.maneuver["joint"]), f"run {run}")
    joint, on = plan.joints[j], str(request.maneuver["on"])
    piece = plan.program.pieces[number]
    samples = (piece.at(k * period_s) for k in range(count))
    excitation = np.array([each[3][j] if on == "command" else each[0][j] for each in samples])
    conditions = ResponseConditions(
        joint, on, float(np.max(np.abs(excitation - excitation[0]))), _mean(log, "prismatic.position", part), _oil_C(log, joint, part),
        rig.link_mode.payload_kg if rig.link_mode is not None else nan,
        _mean(log, f"{joint}.position", part) if rig.arm.kind == "single_axis" else nan,
    )  # fmt: skip
    command, position = (
        without_gaps(np.asarray(log.columns[f"{joint}.{name}"][part], dtype=np.float64)) for name in ("command_V", "position")
    )
    return ExcitedRun(run, conditions, request.maneuver, period_s, excitation - excitation[0], command, position)


def _oil_C(log: Log, joint: str, rows: Column) -> float:
    """Nearest to the oil in the actuator: the valve's return port, else the reservoir."""
    port = _mean(log, f"{joint}.return_temperature_C", rows)
    return port if np.isfinite(port) else _mean(log, "reservoir_temperature_C", rows)


def _mean(log: Log, name: str, rows: Column) -> float:
    values = log.columns.get(name, np.array([]))[rows] if name in log.columns else np.array([])
    return float(np.nanmean(values)) if np.any(np.isfinite(values)) else float("nan")
