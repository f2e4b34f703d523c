"""A run of either kind from its request: a program, or driven by hand; and the motion that belongs to it."""

from __future__ import annotations

from collections.abc import Sequence

from config.schema.rig import Rig
from servo_control.planning.motion import Motion
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan
from servo_control.planning.run_request import RunRequest
from servo_control.streaming.stream_motion import StreamMotion
from servo_control.streaming.stream_plan import StreamPlan, plan_stream

AnyPlan = RunPlan | StreamPlan
AnyMotion = Motion | StreamMotion


def plan_any(rig: Rig, request: RunRequest) -> AnyPlan:
    """Raises ManeuverError as plan_run and plan_stream."""
    return plan_stream(rig, request) if request.by_hand else plan_run(rig, request)


def begin(
    plan: AnyPlan, held: Sequence[float], rate_limits: Sequence[float], acceleration_limits: Sequence[float], period_s: float
) -> AnyMotion:
    """From rest at `held`."""
    if isinstance(plan, StreamPlan):
        return StreamMotion(plan, held)
    return Motion(plan, held, rate_limits, acceleration_limits, period_s)
