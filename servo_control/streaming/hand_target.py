"""The joints' targets when someone drives: as near to what is wanted as travel, rate and acceleration allow, cycle by cycle.

Every cycle each joint gets the rate that is nearest to the wanted one, changes by no more than a T, and is never faster than it could
stop before the end of its travel (`braking.fastest`). Joints that move the tip together keep their proportion: where one is held
back, the others wait, so that the tip slows down on its way and does not leave it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from servo_control.numerics.limits import clamp
from servo_control.streaming.braking import fastest

Bounds = tuple[float, float]


class HandTarget:
    """`position` and `rate` of every joint (rad or m, per s), at first at rest where the arm is held."""

    __slots__ = ("_accelerations", "_bounds", "_period_s", "_rates", "position", "rate")

    def __init__(
        self, held: Sequence[float], travel: Sequence[Bounds], rates: Sequence[float], accelerations: Sequence[float], period_s: float
    ) -> None:
        """A joint that is held outside its travel may come back, and go no farther."""
        self._bounds = [(min(low, at), max(high, at)) for at, (low, high) in zip(held, travel, strict=True)]
        self._rates, self._accelerations, self._period_s = tuple(rates), tuple(accelerations), period_s
        self.position = list(held)
        self.rate = [0.0] * len(self.position)

    def bounds(self, joint: int) -> Bounds:
        return self._bounds[joint]

    def rate_to(self, joint: int, target: float) -> float:
        """The rate that takes the joint to `target` soonest and rests there."""
        way = target - self.position[joint]
        rate = fastest(abs(way), self._accelerations[joint], self._period_s)
        return rate if way > 0.0 else -rate

    def step(self, wanted: Sequence[float], together: bool) -> None:
        """One cycle towards the wanted rates; `together`: the joints keep their proportion."""
        period_s, accelerations = self._period_s, self._accelerations
        allowed = [self._allowed(j) for j in range(len(self.position))]
        wanted = _scaled(wanted, allowed) if together else [clamp(w, -down, up) for w, (down, up) in zip(wanted, allowed, strict=True)]
        changes = [clamp(w - v, -a * period_s, a * period_s) for w, v, a in zip(wanted, self.rate, accelerations, strict=True)]
        if together:
            changes = _in_proportion(changes, wanted, self.rate)
        for j, (down, up) in enumerate(allowed):
            self.rate[j] = rate = clamp(self.rate[j] + changes[j], -down, up)
            self.position[j] = clamp(self.position[j] + rate * period_s, *self._bounds[j])  # but for rounding it is within

    def _allowed(self, joint: int) -> tuple[float, float]:
        """The largest rates downwards and upwards, neither negative."""
        low, high = self._bounds[joint]
        at, limit, acceleration = self.position[joint], self._rates[joint], self._accelerations[joint]
        down, up = (fastest(way, acceleration, self._period_s) for way in (at - low, high - at))
        return min(limit, down), min(limit, up)

    @property
    def at_rest(self) -> bool:
        return not any(self.rate)

    def snapshot(self) -> dict[str, Any]:
        return {"position": list(self.position), "rate": list(self.rate), "bounds": [list(pair) for pair in self._bounds]}

    def restore(self, state: dict[str, Any]) -> None:
        self.position, self.rate = list(state["position"]), list(state["rate"])
        self._bounds = [(low, high) for low, high in state["bounds"]]


def _scaled(wanted: Sequence[float], allowed: Sequence[tuple[float, float]]) -> list[float]:
    """All by the same factor, so that none is above what it may."""
    factor = 1.0
    for rate, (down, up) in zip(wanted, allowed, strict=True):
        most = up if rate > 0.0 else down
        if abs(rate) * factor > most:
            factor = most / abs(rate)
    return [factor * rate for rate in wanted]


def _in_proportion(changes: Sequence[float], wanted: Sequence[float], rates: Sequence[float]) -> list[float]:
    """The share of the way to the wanted rates that every joint can go in this cycle."""
    ways = [w - v for w, v in zip(wanted, rates, strict=True)]
    share = min((change / way for change, way in zip(changes, ways, strict=True) if way != 0.0), default=0.0)
    return [share * way for way in ways]
