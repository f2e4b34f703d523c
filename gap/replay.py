"""The hold-out's run once more in closed loop: plant and controller simulated from the reference, nothing fitted and nothing reset.

An independent check: the fit saw the logged commands; here the controller makes its own, and commands and tracking errors must come
out as they were measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from config.errors import LongreachError
from config.rig import Rig
from control.planning import plan_run
from control.run_request import RunRequest
from control.signals import Mode
from gap.closed_loop import ClosedLoop, closed_loop
from gap.measured import Array
from recording.reader import Log, read_log
from sim_backend.batch import quiet
from sim_backend.plant import SimulatedRig

SMOOTH_S = 0.05
LONGEST_S = 20.0  # of a run that is replayed: enough to see how it went; a controller takes a tenth of real time to simulate


@dataclass(frozen=True, slots=True)
class JointReplay:
    """One joint over a run: commands (V) and tracking errors (rad or m), measured, with the rig file, with the improved one.

    All are means over SMOOTH_S: a controller makes sensor noise into command noise, which no simulation repeats.
    """

    joint: str
    unit: str
    t_s: Array
    commands_V: tuple[Array, Array, Array]
    errors: tuple[Array, Array, Array]

    def rms(self) -> tuple[float, float, float, float]:
        """Of command (V) before and after, and of tracking error before and after, each against the measured one."""
        pairs = [(values[0], simulated) for values in (self.commands_V, self.errors) for simulated in values[1:]]
        differences = [float(np.sqrt(np.mean((simulated - measured) ** 2))) for measured, simulated in pairs]
        return differences[0], differences[1], differences[2], differences[3]


def replays(path: Path, before: Rig, after: Rig) -> list[JointReplay] | str:
    """Every joint of the log's first run (its first 20 s), or why it cannot be replayed."""
    if path.suffix.lower() != ".mcap":
        return "The hold-out is a table without the run's request, so the controller cannot be run again."
    log = read_log(path)
    request = next((log.attachments[name] for name in sorted(log.attachments) if name.startswith("run-")), None)
    rows = np.flatnonzero(log.columns["mode"] == int(Mode.RUNNING))
    if request is None or rows.size == 0:
        return "The hold-out holds no run of a maneuver, so the controller cannot be run again."
    start = [float(log.columns[f"{joint}.position"][rows[0]]) for joint in before.joints]
    try:
        runs = [_run(rig, request.decode(), start) for rig in (before, after)]
    except LongreachError as refused:
        return f"The hold-out's run cannot be planned with this rig file: {refused.refusal.what}."
    return [_joint(log, rows, runs, number, joint, before) for number, joint in enumerate(before.joints)]


def _run(rig: Rig, request: str, start: list[float]) -> ClosedLoop:
    simulated = SimulatedRig(rig)
    simulated.parameters.values[:] = quiet(simulated.parameters)
    simulated.reset(start)
    return closed_loop(rig, simulated, plan_run(rig, RunRequest.from_json(request)), LONGEST_S)


def _joint(log: Log, rows: NDArray[np.intp], runs: list[ClosedLoop], number: int, joint: str, rig: Rig) -> JointReplay:
    """Measured and simulated rows side by side, both from the first row of the run."""
    columns = {name: np.asarray(log.columns[f"{joint}.{name}"], dtype=np.float64) for name in ("command_V", "reference", "position")}
    count = min(rows.size, *(run.running for run in runs))
    part = rows[:count]
    error = columns["reference"] - columns["position"]
    commands = [columns["command_V"][part], *(run.commands_V[-run.running :, number][:count] for run in runs)]
    errors = [error[part], *(run.following_error[-run.running :, number][:count] for run in runs)]
    commands, errors = ([_smooth(values, rig) for values in series] for series in (commands, errors))
    unit = "rad" if rig.joints[joint].motion == "rotary" else "m"
    t_s = np.arange(count) / rig.loop.rate_Hz
    return JointReplay(joint, unit, t_s, (commands[0], commands[1], commands[2]), (errors[0], errors[1], errors[2]))


def _smooth(values: Array, rig: Rig) -> Array:
    return np.asarray(uniform_filter1d(values, max(round(SMOOTH_S * rig.loop.rate_Hz), 1), mode="nearest"))
