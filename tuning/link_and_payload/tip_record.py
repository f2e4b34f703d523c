"""What the tip and the joints did in one run, as measured: the material from which payload, link frequency and damping are found."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import pi

import numpy as np

from config.errors import LogError
from config.schema.rig import Rig
from recording.evaluation.spectrum import without_gaps
from recording.evaluation.vibration import APPROACH, TIP
from recording.files.reader import Column, Log, open_rig
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Mode
from tuning.arrays import Floats

SKIPPED_S = 0.1  # after the reference has come to rest, while the joint does
SHORTEST_HOLD_S = 0.5
_NEEDED = ("prismatic.position", "rotary.position", TIP)


@dataclass(frozen=True, slots=True)
class TipRecord:
    """One run. Tip acceleration (m/s²), deflection (m; None: not measured), rotary position (rad), extension (m), one value a period;
    `holds`: rows in which the references stand still, with the number of the move before. `tip_lag_s`: time constant of the
    accelerometer, if the rig file's plant section knows its bandwidth. `torn`: moves whose holds are left out, because the log lacks
    cycles of them."""

    run: int
    period_s: float
    acceleration: Floats
    deflection: Floats | None
    rotary: Floats
    extension: Floats
    holds: tuple[tuple[int, slice], ...]
    tip_lag_s: float = 0.0
    torn: tuple[int, ...] = ()


def tip_records(log: Log, rig: Rig | None = None) -> list[TipRecord]:
    """Every run of the log. `rig`: for imported data, which carry none. Raises LogError when a signal is missing or nothing ran."""
    lacking = [name for name in _NEEDED if not np.any(np.isfinite(log.columns.get(name, np.array([np.nan]))))]
    if lacking:
        raise LogError("the log lacks what the link's motion is found from", value=", ".join(lacking), where=str(log.path))
    running = log.columns["mode"] == Mode.RUNNING
    records = [_record(log, run, np.flatnonzero(running & (log.columns["maneuver"] == run)), rig) for run in _runs(log, running)]
    if not records:
        raise LogError("no run in the log", where=str(log.path), next_step="Record a move, e.g. `longreach start joint_steps --wait`.")
    return records


def move_holds(plan: RunPlan, period_s: float) -> Iterator[tuple[int, slice]]:
    """Rows of every hold after a move of the program, counted from the run's first; the shaper's tail and a short while are left out."""
    moves = 0
    segments = plan.segments
    for move, after in pairwise(segments):
        if move.kind != "move" or move.name == APPROACH:
            continue
        moves += 1
        start_s = move.end_s + plan.flush_s + SKIPPED_S
        if after.kind == "hold" and after.end_s - start_s >= SHORTEST_HOLD_S:
            yield moves, slice(round(start_s / period_s), round(after.end_s / period_s))


def _runs(log: Log, running: Column) -> list[int]:
    return [int(run) for run in np.unique(log.columns["maneuver"][running])]


def _record(log: Log, run: int, rows: Column, rig: Rig | None) -> TipRecord:
    period_s = float(np.median(np.diff(log.columns["t_s"])))
    acceleration, rotary, extension = (without_gaps(_by_cycle(log, name, rows)) for name in (TIP, "rotary.position", "prismatic.position"))
    deflection = _by_cycle(log, "tip.deflection_m", rows)
    there = np.isfinite(_by_cycle(log, "cycle", rows))
    holds: list[tuple[int, slice]] = []
    rig = rig or open_rig(log)
    request = RunRequest.from_json(log.attachments[f"run-{run}.json"]) if f"run-{run}.json" in log.attachments else None
    if request is not None and not request.by_hand:
        plan = plan_run(rig, request)
        holds = [(move, part) for move, part in move_holds(plan, period_s) if part.stop <= len(there) + 1]
    whole = tuple((move, part) for move, part in holds if there[part].all())
    torn = tuple(move for move, part in holds if not there[part].all())
    measured = without_gaps(deflection) if np.any(np.isfinite(deflection)) else None
    return TipRecord(run, period_s, acceleration, measured, rotary, extension, whole, _tip_lag_s(rig), torn)


def _by_cycle(log: Log, name: str, rows: Column) -> Floats:
    """A column of a run at its place in time, one value a period from the first row on: NaN for cycles that the log lacks, and where there
    is no such column."""
    cycle = log.columns["cycle"][rows].astype(np.int64)
    values = np.full(int(cycle[-1] - cycle[0]) + 1, np.nan)
    if name in log.columns:
        values[cycle - cycle[0]] = log.columns[name][rows]
    return values


def _tip_lag_s(rig: Rig) -> float:
    sensor = rig.plant.sensors.get("tip.acceleration") if rig.plant is not None else None
    bandwidth_Hz = getattr(sensor, "bandwidth_Hz", None)
    return 1.0 / (2.0 * pi * bandwidth_Hz) if bandwidth_Hz else 0.0
