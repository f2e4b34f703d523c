"""A planned run without a rig: every cycle's targets and shaped references. For checks before a run, design and figures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from config.schema.rig import Rig
from servo_control.planning.motion import Motion
from servo_control.planning.run_plan import RunPlan


@dataclass(frozen=True, slots=True)
class Predicted:
    """One cycle: time since the first RUNNING cycle in s; per joint target, target rate, reference, reference rate (rad or m)."""

    t_s: float
    segment: int
    target: tuple[float, ...]
    target_rate: tuple[float, ...]
    reference: tuple[float, ...]
    reference_rate: tuple[float, ...]


def predict(rig: Rig, plan: RunPlan) -> Iterator[Predicted]:
    """The cycles of the run from its exact start until program and shaper are at rest, as the controller would make them."""
    period_s = 1.0 / rig.loop.rate_Hz
    joints = rig.joints.values()
    motion = Motion(plan, plan.start_position, [j.rate_limit for j in joints], [j.acceleration_limit for j in joints], period_s)
    cycle = 0
    while not motion.done:
        motion.advance(stop=False)
        yield Predicted(
            cycle * period_s,
            motion.segment,
            tuple(motion.target),
            tuple(motion.target_rate),
            tuple(motion.reference),
            tuple(motion.reference_rate),
        )
        cycle += 1
