"""A run driven by hand without a rig: set points in, targets and references out, cycle by cycle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from config.schema.rig import Rig
from servo_control.planning.run_request import RunRequest
from servo_control.signals import SetPoint
from servo_control.streaming.stream_motion import StreamMotion
from servo_control.streaming.stream_plan import StreamPlan, default_filter, plan_stream

HOME = (0.0, 1.0)


def stream_plan(rig: Rig, start: Sequence[float] = HOME, shaper: dict[str, object] | None = None) -> StreamPlan:
    content = {"name": "by hand", "kind": "stream"}
    return plan_stream(rig, RunRequest(1, content, default_filter(rig) if shaper is None else shaper, start_position=list(start)))


@dataclass
class HandDriven:
    """Rows of every cycle, each with a value of every joint."""

    motion: StreamMotion
    target: list[list[float]] = field(default_factory=list)
    target_rate: list[list[float]] = field(default_factory=list)
    reference: list[list[float]] = field(default_factory=list)
    reference_rate: list[list[float]] = field(default_factory=list)

    def cycle(self, point: SetPoint | None = None, stop: bool = False) -> None:
        motion = self.motion
        motion.take(point)
        motion.advance(stop=stop)
        for rows, values in (
            (self.target, motion.target),
            (self.target_rate, motion.target_rate),
            (self.reference, motion.reference),
            (self.reference_rate, motion.reference_rate),
        ):
            rows.append(list(values))

    def drive(self, wanted: int, values: Sequence[float], cycles: int, every: int = 20) -> None:
        """The same set point again and again."""
        for number in range(cycles):
            self.cycle(SetPoint(1, wanted, tuple(values), 0.0) if number % every == 0 else None)

    def until_done(self, stop: bool = False, most: int = 5000) -> int:
        for number in range(most):
            self.cycle(stop=stop)
            if self.motion.done:
                return number + 1
        raise AssertionError(f"not at rest after {most} cycles")


def hand_driven(rig: Rig, start: Sequence[float] = HOME, shaper: dict[str, object] | None = None) -> HandDriven:
    return HandDriven(StreamMotion(stream_plan(rig, start, shaper), list(start)))
