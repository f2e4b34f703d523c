"""What one simulated run is worth, from its log alone: how long, how close, how hard, and what vibration is left."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from config.errors import LogError
from recording.evaluation.vibration import hold_vibration, rms_mps2
from recording.files.reader import Log, read_log
from servo_control.signals import Mode


@dataclass(frozen=True, slots=True)
class JointOutcome:
    """Over the run, in the joint's unit (rad or m): reference − position, and the command in V."""

    rms_error: float
    largest_error: float
    last_error: float
    largest_command_V: float


@dataclass(frozen=True, slots=True)
class RunOutcome:
    """`tip_vibration_mps2`: rms over the holds of the amplitude 1.0 s after each move; NaN where the rig has no flexible tip."""

    log: Path
    duration_s: float
    joints: Mapping[str, JointOutcome]
    tip_vibration_mps2: float
    largest_tip_acceleration_mps2: float

    def as_dict(self) -> dict[str, Any]:
        return asdict(self) | {"log": str(self.log)}


def outcome(path: Path) -> RunOutcome:
    """Of the log of one run."""
    log = read_log(path)
    running = log.columns["mode"] == Mode.RUNNING
    t = log.columns["t_s"][running]
    tip = log.columns.get("tip.acceleration_mps2", np.full(log.cycles, np.nan))[running]
    joints = {joint: _joint(log, joint, running) for joint in log.layout.joint_names}
    largest = float(np.nanmax(np.abs(tip))) if np.any(np.isfinite(tip)) else nan
    return RunOutcome(path, float(t[-1] - t[0]), joints, _vibration(log), largest)


def _joint(log: Log, joint: str, running: np.ndarray[Any, np.dtype[np.bool_]]) -> JointOutcome:
    error = (log.columns[f"{joint}.reference"] - log.columns[f"{joint}.position"])[running]
    command = log.columns[f"{joint}.command_V"][running]
    rms = float(np.sqrt(np.nanmean(error**2)))
    return JointOutcome(rms, float(np.nanmax(np.abs(error))), float(error[-1]), float(np.nanmax(np.abs(command))))


def _vibration(log: Log) -> float:
    try:
        return rms_mps2(hold_vibration(log))
    except LogError:  # no flexible link, no accelerometer, or no hold after a move
        return nan
