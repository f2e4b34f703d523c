"""Where the program of a run begins in its log: behind the slow approach and the hold in which the arm comes to rest, if it had them."""

from __future__ import annotations

import numpy as np

from config.errors import LongreachError
from recording.evaluation.vibration import APPROACH
from recording.files.info import run_of
from recording.files.reader import Log, open_rig
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Mode

APPROACH_SEGMENTS = 2  # the slow move and the hold after it


def plan_of(log: Log, run: int) -> RunPlan | None:
    """None where it cannot be planned again: no request, or a rig file of another version."""
    try:
        return plan_run(open_rig(log), RunRequest.from_json(log.attachments[f"run-{run}.json"]))
    except (LongreachError, KeyError):
        return None


def program_start_s(log: Log, run: int, plan: RunPlan | None) -> float:
    """The log's t_s; the start of the run where it never came so far."""
    approached = bool(plan and plan.segments and plan.segments[0].name == APPROACH)
    running = (log.columns["maneuver"] == run) & (log.columns["mode"] == Mode.RUNNING)
    rows = np.flatnonzero(running & (log.columns["segment"] > APPROACH_SEGMENTS * approached))
    return float(log.columns["t_s"][rows[0]]) if len(rows) else run_of(log, run).start_t_s
