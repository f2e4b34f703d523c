"""When the plant of the twin moves: one period at every SYNC, and by the wall clock when SYNC does not come.

Stepping by SYNC keeps the plant's time equal to the controller's cycles, so that jitter of a busy machine does not look like a plant
that jumps. When the controller is gone, or has skipped cycles, the plant has to go on: periods that the wall clock is ahead are
caught up as soon as they are `TOLERATED_PERIODS`; so the plant is at most that much behind the wall clock.
"""

from __future__ import annotations

TOLERATED_PERIODS = 3
LONGEST_CATCH_UP_PERIODS = 1000  # a process that was stopped for longer finds the plant only this much later


class StepClock:
    """Counts plant periods. SYNCs that come faster than the rig's rate take the plant's time with them."""

    def __init__(self, period_s: float) -> None:
        self._period_ns = round(1e9 * period_s)
        self._plant_ns: int | None = None
        self.caught_up = 0

    def at_sync(self, now_ns: int) -> int:
        """Periods to advance at a SYNC: one, and more after a gap."""
        return self._advance(1, now_ns)

    def between(self, now_ns: int) -> int:
        """Periods to advance although no SYNC came."""
        return self._advance(0, now_ns)

    def _advance(self, periods: int, now_ns: int) -> int:
        if self._plant_ns is None:
            self._plant_ns = now_ns
        behind = (now_ns - self._plant_ns) // self._period_ns
        if behind >= TOLERATED_PERIODS:
            lost = max(0, behind - LONGEST_CATCH_UP_PERIODS)
            self._plant_ns += lost * self._period_ns
            self.caught_up += behind - lost - periods
            periods = behind - lost
        self._plant_ns = min(self._plant_ns + periods * self._period_ns, now_ns)
        return periods
