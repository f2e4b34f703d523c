"""Whether a set point can be followed, and how the run stands: the numbers by which the checks end a run that is driven by hand.

The motion asks it in the loop; `longreach why` asks it of the set points of a log. What was wrong stays until the run is over.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import hypot, isfinite
from typing import Any

from servo_control.numerics.limits import ROUNDING
from servo_control.signals import Driving, SetPoint, Wanted
from servo_control.streaming.hand_target import Bounds
from servo_control.streaming.stream_plan import StreamPlan


class SetPointJudge:
    """`take` once a cycle; then `driving` is how the run stands. `ended`: it was asked to end or is stopped, and silence is no fault."""

    __slots__ = ("_bounds", "_plan", "_silent_cycles", "driving", "ended")

    def __init__(self, plan: StreamPlan, bounds: Callable[[int], Bounds]) -> None:
        """`bounds`: where the target of a joint may be."""
        self._plan, self._bounds = plan, bounds
        self._silent_cycles = 0
        self.ended = False
        self.driving = Driving()

    def take(self, point: SetPoint | None) -> bool:
        """The set point of this cycle, None when there is none. True for one that can be followed."""
        self._silent_cycles += 1
        usable = point is not None and self._judge(point)
        silent_s = 0.0 if self.ended else self._silent_cycles * self._plan.shaper.period_s
        self.driving = self.driving._replace(silent_s=silent_s)
        return usable

    def _judge(self, point: SetPoint) -> bool:
        unusable = float(sum(not isfinite(value) for value in point.values))
        reach = 0.0 if unusable else self._reach(point)
        before, left = self.driving, float(point.wanted == Wanted.CLIENT_LEFT)
        self.driving = Driving(
            before.silent_s,
            max(before.late_s, point.late_s),
            before.unusable + unusable,
            max(before.reach, reach),
            max(before.client_left, left),
        )
        if unusable or reach > ROUNDING or left or point.late_s > self._plan.timeout_s:
            return False
        self._silent_cycles = 0
        self.ended = self.ended or point.wanted == Wanted.END
        return True

    def _reach(self, point: SetPoint) -> float:
        """The largest share of its limit that is asked for; of a position as far as the middle of the travel is from its end."""
        plan, values = self._plan, point.values
        if point.wanted == Wanted.TIP:
            return hypot(*values) / plan.tip_speed_mps if plan.tip_speed_mps > 0.0 else 2.0
        if point.wanted == Wanted.RATE:
            return max(abs(rate) / limit for rate, limit in zip(values, plan.rate_limits, strict=True))
        if point.wanted == Wanted.TARGET:
            return max(_share(position, *self._bounds(j)) for j, position in enumerate(values))
        return 0.0

    def snapshot(self) -> dict[str, Any]:
        return {"silent_cycles": self._silent_cycles, "end": self.ended, "driving": list(self.driving)}

    def restore(self, state: Mapping[str, Any]) -> None:
        self._silent_cycles, self.ended, self.driving = state["silent_cycles"], state["end"], Driving(*state["driving"])


def _share(position: float, low: float, high: float) -> float:
    return abs(position - 0.5 * (low + high)) / (0.5 * (high - low))
