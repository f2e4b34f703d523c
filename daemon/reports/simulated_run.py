"""The run of a log again on the simulated rig of that log: its rig file, request, start position and oil temperature, in lockstep."""

from __future__ import annotations

import dataclasses
import tempfile
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from config.errors import LogError
from config.loading.load import LoadedRig
from config.loading.stand_in import with_simulated_devices
from config.schema.rig import Rig
from daemon.lockstep import LockstepRig
from daemon.loop.command import LoopCommand, StartRun
from recording.files.reader import Log, open_rig, read_log
from servo_control.planning.planning import plan_run
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Mode


def simulated_run(log: Log, run: int) -> Log:
    """The log of the same run on the simulated rig.

    LogError where the rig file has no `plant:` section or the log no request; ConfigError where the plant lacks what a device measures;
    refusals of the run as those of `start`.
    """
    logged = LoadedRig(open_rig(log), log.attachments["rig.yaml"].decode(), f"{log.path.name}:rig.yaml")
    if logged.rig.plant is None:
        raise LogError("the rig file in the log has no plant to simulate", where=str(log.path), next_step="Add `plant:` to the rig file.")
    rows = np.flatnonzero((log.columns["maneuver"] == run) & (log.columns["mode"] == Mode.RUNNING))
    request = RunRequest.from_json(log.attachments[f"run-{run}.json"])
    loaded = with_simulated_devices(logged)
    start = _starting(log, loaded.rig, int(rows[0]))
    loaded = LoadedRig(start, loaded.text, loaded.path)
    with tempfile.TemporaryDirectory(prefix="longreach-report-") as folder, LockstepRig(loaded, Path(folder)) as lockstep:
        lockstep.arm()
        held = [lockstep.value(f"{joint}.reference") for joint in start.joints]
        request = dataclasses.replace(request, start_position=held)
        text = log.attachments.get(f"maneuver-{run}.yaml", b"").decode()
        lockstep.commands.post(LoopCommand(start=StartRun(plan_run(start, request), request.as_json(), text, 0.0)))
        lockstep.cycles(2)
        every = round(0.1 * start.loop.rate_Hz)
        while lockstep.loop.keeper.run.active:
            lockstep.cycles(every)
        lockstep.disarm()
        lockstep.cycles(2 * round(start.loop.rate_Hz) if lockstep.mode is Mode.FAULT else 2)  # a fault records on
        return read_log(lockstep.recorder.finished[-1])


def _starting(log: Log, rig: Rig, row: int) -> Rig:
    """The plant at the joints' positions and the oil's temperature of this row."""
    assert rig.plant is not None
    joints = dict(rig.plant.joints)
    for name, joint in joints.items():
        position = float(log.columns[f"{name}.position"][row])
        if isfinite(position):
            joints[name] = joint.model_copy(update={"initial": position})
    oil = [float(log.columns[name][row]) for name in log.columns if name.endswith("_temperature_C")]
    known = [value for value in oil if isfinite(value)]
    changes: dict[str, Any] = {"joints": joints}
    if known and rig.plant.oil is not None:
        changes["oil"] = rig.plant.oil.model_copy(update={"initial_temperature_C": float(np.median(known))})
    return rig.model_copy(update={"plant": rig.plant.model_copy(update=changes)})
