"""A run that is driven by hand: set points become targets, targets go through the run's command filter.

Without a usable set point, and in a controlled stop, the joints slow down as fast as they may. `driving` are the numbers by which the
checks end such a run. The run ends where it is asked to, or stopped, once the target has rested for as long as the filter takes.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Any

from servo_control.signals import Driving, SetPoint, Wanted
from servo_control.streaming.hand_target import HandTarget
from servo_control.streaming.set_point_judge import SetPointJudge
from servo_control.streaming.stream_plan import StreamPlan


class StreamMotion:
    """Starts at rest at the held targets. `take` and `advance` once a cycle; then `reference` is what the servos follow."""

    __slots__ = (
        "_asked", "_flush_cycles", "_hand", "_judge", "_rest_cycles", "_shaper", "_together", "_wanted", "done", "plan",
        "reference", "reference_rate", "segment", "target", "target_rate", "volts",
    )  # fmt: skip

    def __init__(self, plan: StreamPlan, held: Sequence[float]) -> None:
        self.plan = plan
        self._hand = HandTarget(held, plan.travel, plan.rates, plan.accelerations, plan.shaper.period_s)
        self._judge = SetPointJudge(plan, self._hand.bounds)
        self._shaper = plan.shaper.build()
        self._shaper.reset(held)
        self._flush_cycles = ceil(self._shaper.flush_s / plan.shaper.period_s)
        self._wanted = 0  # 0: rest
        self._asked: tuple[float, ...] = ()
        self._together = False  # the last thing asked for was a motion of the tip: the joints slow down in proportion
        self._rest_cycles = 0
        self.done = False
        self.target, self.reference = list(held), list(held)
        self.target_rate, self.reference_rate = [0.0] * len(held), [0.0] * len(held)
        self._shaper.step(self.target, self.target_rate, self.reference, self.reference_rate)  # its first sample is at rest
        self.volts: Sequence[float] = [0.0] * len(held)
        self.segment = 1

    @property
    def driving(self) -> Driving:
        return self._judge.driving

    def take(self, point: SetPoint | None) -> None:
        """The set point of this cycle, None when there is none; those of another run are none."""
        if point is not None and point.run != self.plan.run:
            point = None
        usable, ended = self._judge.take(point), self._judge.ended
        if point is None:
            return
        if not usable:
            self._wanted = 0
            return
        self._wanted, self._asked = (0, ()) if ended else (point.wanted, point.values)
        self._together = self._wanted == Wanted.TIP or (ended and self._together)

    def advance(self, *, stop: bool) -> None:
        """One cycle. `stop`: slow down, and do not move any more."""
        self._judge.ended = self._judge.ended or stop
        self._hand.step(self._rates(), self._together)
        self._rest_cycles = self._rest_cycles + 1 if self._hand.at_rest else 0
        self.target, self.target_rate = list(self._hand.position), list(self._hand.rate)
        self._shaper.step(self.target, self.target_rate, self.reference, self.reference_rate)
        self.done = self._judge.ended and self._rest_cycles > self._flush_cycles

    def _rates(self) -> Sequence[float]:
        """What the joints should do now."""
        asked = self._asked
        if self._judge.ended or self._wanted == 0:
            return [0.0] * len(self.target)
        if self._wanted == Wanted.RATE:
            return asked
        if self._wanted == Wanted.TARGET:
            return [self._hand.rate_to(j, position) for j, position in enumerate(asked)]
        return self.plan.joint_rates(self._hand.position, asked)

    def snapshot(self) -> dict[str, Any]:
        """All but the plan, which its request gives again."""
        return {
            "hand": self._hand.snapshot(),
            "shaper": self._shaper.snapshot(),
            "wanted": self._wanted,
            "asked": list(self._asked),
            "together": self._together,
            "rest_cycles": self._rest_cycles,
            **self._judge.snapshot(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """On a motion made from the same plan."""
        self._hand.restore(state["hand"])
        self._shaper.restore(state["shaper"])
        self._wanted, self._asked = state["wanted"], tuple(state["asked"])
        self._rest_cycles, self._together = state["rest_cycles"], state["together"]
        self._judge.restore(state)
        self.target, self.target_rate = list(self._hand.position), list(self._hand.rate)
