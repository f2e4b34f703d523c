"""Limits inside the loop. They are the last line: a planned run never touches them."""

from __future__ import annotations

# A reference planned exactly at a limit must not be clipped because of rounding.
ROUNDING = 1.0 + 1e-9


def clamp(value: float, low: float, high: float) -> float:
    """`value` limited to [low, high]."""
    return low if value < low else high if value > high else value


class ReferenceLimit:
    """Keeps a joint's reference inside its travel and its slope below the rate limit (rad or m).

    An arm that rests outside its travel when the servo engages is not pulled in by a jump: the bound is widened to
    where it rests.
    """

    __slots__ = ("_step", "_travel", "high", "low", "rate_limit")

    def __init__(self, travel: tuple[float, float], rate_limit: float, period_s: float) -> None:
        self._travel = travel
        self.low, self.high = travel
        self.rate_limit = rate_limit * ROUNDING
        self._step = self.rate_limit * period_s

    def engage(self, position: float) -> None:
        """Start at `position`."""
        self.low = min(self._travel[0], position)
        self.high = max(self._travel[1], position)

    def apply(self, wanted: float, previous: float) -> float:
        """The reference that may follow `previous`."""
        inside = clamp(wanted, self.low, self.high)
        return clamp(inside, previous - self._step, previous + self._step)


class CommandLimit:
    """Keeps the command within ± limit_V and its slope below rate_V_per_s; both are one interval around the last command."""

    __slots__ = ("_limit", "_step")

    def __init__(self, limit_V: float, rate_V_per_s: float, period_s: float) -> None:
        self._limit = limit_V
        self._step = rate_V_per_s * period_s

    def apply(self, wanted_V: float, previous_V: float) -> float:
        """The command that may follow `previous_V`."""
        low = max(-self._limit, previous_V - self._step)
        high = min(self._limit, previous_V + self._step)
        return clamp(wanted_V, low, high)
