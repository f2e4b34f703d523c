"""How a run that was driven by hand stood in every row of a log, from its set points: the same judge as in the loop."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np

from config.schema.rig import Rig
from recording.files.reader import Log
from servo_control.planning.run_request import RunRequest
from servo_control.signals import NOT_DRIVEN, Driving, Mode
from servo_control.streaming.hand_target import HandTarget
from servo_control.streaming.set_point_judge import SetPointJudge
from servo_control.streaming.stream_plan import plan_stream

_ENGAGED = (Mode.HOLDING, Mode.RUNNING, Mode.STOPPING)  # a motion that is over there has come to rest; elsewhere it was broken off


def driving_is_known(log: Log) -> bool:
    """Whether the log holds the request of every run that was driven by hand, and all cycles of its motion: the judge remembers."""
    requests = _requests(log)
    owned = {stamped.point.run for stamped in log.set_points} <= set(requests)
    return log.kind == "recorded" and owned and _has_all_cycles(log, requests)


def _has_all_cycles(log: Log, requests: dict[int, RunRequest]) -> bool:
    """Of motions by hand; what the first row needs of the cycles before is in the controller's state."""
    if not log.cycles or not requests:
        return True
    cycle = log.columns["cycle"].astype(np.int64)
    first = cycle[0] if log.begun_cycle is None else log.begun_cycle
    by_hand = (log.columns["segment"] != 0) & np.isin(log.columns["maneuver"], list(requests))
    seen_from_both_ends = by_hand | np.append(False, by_hand[:-1])  # the last of a motion may be what is missing
    return bool(np.all(np.diff(cycle, prepend=first - 1)[seen_from_both_ends] == 1))


def driving_before(log: Log, rig: Rig, start: int, end: int) -> Iterator[Driving]:
    """What the checks of each row from `start` to `end` read: how the run stood after the cycle before."""
    requests = _requests(log)
    begins = _begins(log, start) if requests else start
    return (driving for row, driving in _followed(log, rig, requests, begins, end) if row >= start)


def _followed(log: Log, rig: Rig, requests: dict[int, RunRequest], start: int, end: int) -> Iterator[tuple[int, Driving]]:
    points = {stamped.cycle: stamped.point for stamped in log.set_points}
    columns = (log.columns[name][start : end + 1].tolist() for name in ("cycle", "mode", "maneuver", "segment"))
    judge: SetPointJudge | None = None
    driving = NOT_DRIVEN
    for row, (cycle, mode, run, segment) in enumerate(zip(*columns, strict=True), start):
        if not segment:
            judge = None
            driving = NOT_DRIVEN if mode in _ENGAGED else driving
        yield row, driving
        if not segment or run not in requests:
            driving = NOT_DRIVEN
            continue
        judge = judge or _judge(log, rig, requests[run], row)
        judge.take(points.get(cycle))
        judge.ended |= mode != Mode.RUNNING
        driving = judge.driving


def _begins(log: Log, row: int) -> int:
    """The row in which the motion of `row` began, for what was wrong stays in its numbers; `row` itself where none is under way."""
    at_rest = np.flatnonzero(log.columns["segment"][:row] == 0)
    return int(at_rest[-1]) + 1 if len(at_rest) else 0


def _judge(log: Log, rig: Rig, request: RunRequest, row: int) -> SetPointJudge:
    """As the motion that begins in `row` makes it, or as it was where the log begins in the middle of a motion."""
    plan = plan_stream(rig, request)
    under_way = json.loads(log.attachments["controller_state.json"])["motion"] if row == 0 else None
    held = plan.start_position if row == 0 else [float(log.columns[f"{joint}.target"][row - 1]) for joint in rig.joints]
    hand = HandTarget(held, plan.travel, plan.rates, plan.accelerations, plan.shaper.period_s)
    judge = SetPointJudge(plan, hand.bounds)
    if under_way is not None:
        hand.restore(under_way["hand"])
        judge.restore(under_way)
    return judge


def _requests(log: Log) -> dict[int, RunRequest]:
    """Number → request of the runs that were driven by hand."""
    numbers = {stamped.point.run for stamped in log.set_points} | {int(n) for n in np.unique(log.columns["maneuver"]) if n}
    found = {n: RunRequest.from_json(log.attachments[f"run-{n}.json"]) for n in numbers if f"run-{n}.json" in log.attachments}
    return {n: request for n, request in found.items() if request.by_hand}
