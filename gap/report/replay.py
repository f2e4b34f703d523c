"""The hold-out's run once more in closed loop: plant and controller simulated from the reference, nothing fitted and nothing reset.

An independent check: the fit saw the logged commands; here the controller makes its own, and commands and tracking errors must come
out as they were measured. The run's request is the log's own or a given one; of a table that has neither, the logged reference is followed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import correlate

from config.errors import LongreachError
from config.schema.rig import Rig
from gap.data.logged_run import LoggedRun, logged_run
from gap.data.measured import Array
from gap.maneuvers.closed_loop import ClosedLoop, closed_loop
from sim_backend.kernel.batch import quiet
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


def replays(path: Path, before: Rig, after: Rig, given: Path | None = None) -> list[JointReplay] | str:
    """Every joint of the log's first run (its first 20 s), or why it cannot be replayed. `given`: the run of a log that does not say."""
    try:
        logged = logged_run(path, before, given)
        if isinstance(logged, str):
            return logged
        runs = [_run(rig, logged) for rig in (before, after)]
    except LongreachError as refused:
        return f"The hold-out's run cannot be planned with this rig file: {refused.refusal.what}."
    count = min(run.running for run in runs)
    first = 0 if logged.begun else _begin(logged.columns, runs[1], before, count)
    columns = {name: values[first : first + count] for name, values in logged.columns.items()}
    return [_joint(columns, runs, number, joint, before) for number, joint in enumerate(before.joints)]


def _run(rig: Rig, logged: LoggedRun) -> ClosedLoop:
    simulated = SimulatedRig(rig)
    simulated.parameters.values[:] = quiet(simulated.parameters)
    simulated.reset(logged.start(rig))
    return closed_loop(rig, simulated, logged.planned(rig), LONGEST_S)


def _begin(columns: Mapping[str, Array], run: ClosedLoop, rig: Rig, count: int) -> int:
    """The row at which the simulated positions lie best on the measured ones: Σ(x − y)² over every shift, joints by their span."""
    rows = len(columns["t_s"])
    length = min(count, rows)
    costs = np.zeros(rows - length + 1)
    for joint in rig.joints:
        measured, simulated = columns[f"{joint}.position"], run.signals[f"{joint}.position"][-run.running :][:length]
        middle, span = float(measured.mean()), max(float(np.ptp(measured)), 1e-9)
        x, y = (measured - middle) / span, (simulated - middle) / span
        energy = np.concatenate([[0.0], np.cumsum(x**2)])
        costs += energy[length:] - energy[:-length] - 2.0 * correlate(x, y, mode="valid")
    return int(np.argmin(costs))


def _joint(columns: Mapping[str, Array], runs: list[ClosedLoop], number: int, joint: str, rig: Rig) -> JointReplay:
    """Measured and simulated rows side by side, both from the first row of the run."""
    count = min(len(columns["t_s"]), *(run.running for run in runs))
    errors = [run.following_error[-run.running :, number][:count] for run in runs]
    position = columns[f"{joint}.position"][:count]
    planned = errors[1] + runs[1].signals[f"{joint}.position"][-runs[1].running :][:count]
    reference = columns[f"{joint}.reference"][:count] if f"{joint}.reference" in columns else planned
    commands = [columns[f"{joint}.command_V"][:count], *(run.commands_V[-run.running :, number][:count] for run in runs)]
    commands, errors = ([_smooth(values, rig) for values in series] for series in (commands, [reference - position, *errors]))
    unit = rig.joints[joint].position_unit
    t_s = np.arange(count) / rig.loop.rate_Hz
    return JointReplay(joint, unit, t_s, (commands[0], commands[1], commands[2]), (errors[0], errors[1], errors[2]))


def _smooth(values: Array, rig: Rig) -> Array:
    return np.asarray(uniform_filter1d(values, max(round(SMOOTH_S * rig.loop.rate_Hz), 1), mode="nearest"))
