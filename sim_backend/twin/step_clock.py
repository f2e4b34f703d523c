"""When the plant of the twin moves: one period at every SYNC, and by the wall clock when SYNC does not come.

Stepping by SYNC keeps the plant's time equal to the controller's cycles, so that the jitter of a busy machine does not look like a plant
that jumps: while a controller is late by no more than the tolerated silence, the plant waits for it. After a longer silence (the
controller is gone) the plant catches up with the wall clock and follows it until the next SYNC.
"""

from __future__ import annotations

TOLERATED_S = 0.02  # longer than this class of machine stands still in most minutes, and a third of the shortest device time-out
_FEWEST_TOLERATED_PERIODS = 3
LONGEST_CATCH_UP_PERIODS = 1000  # a process that was stopped for longer finds the plant only this much later


class StepClock:
    """Counts plant periods. Times in ns are those at which SYNC arrived, not those at which this process came to look at it.

    SYNCs that come faster than the rig's rate take the plant's time with them. `caught_up`: periods moved by the wall clock.
    """

    def __init__(self, period_s: float) -> None:
        self._period_ns = round(1e9 * period_s)
        self._tolerated_ns = max(round(1e9 * TOLERATED_S), _FEWEST_TOLERATED_PERIODS * self._period_ns)
        self._plant_ns: int | None = None  # how far on the wall clock the plant is
        self._sync_ns = 0
        self.caught_up = 0

    def at_sync(self, arrived_ns: int) -> int:
        """Periods to advance at a SYNC: one, and more after a long silence."""
        missed = max(0, self._by_wall_clock(arrived_ns) - 1)
        self.caught_up += missed
        self._plant_ns = max(self._plant_ns or 0, arrived_ns)
        self._sync_ns = max(self._sync_ns, arrived_ns)
        return 1 + missed

    def between(self, now_ns: int) -> int:
        """Periods to advance although no SYNC came. To be asked when every SYNC that has arrived was handed in."""
        periods = self._by_wall_clock(now_ns)
        self.caught_up += periods
        return periods

    def _by_wall_clock(self, now_ns: int) -> int:
        """Whole periods up to `now_ns`, when the silence is long enough for the wall clock to rule; the plant is then there."""
        if self._plant_ns is None:
            self._plant_ns = self._sync_ns = now_ns
        if now_ns - self._sync_ns <= self._tolerated_ns:
            return 0
        behind = (now_ns - self._plant_ns) // self._period_ns
        self._plant_ns += behind * self._period_ns
        return min(behind, LONGEST_CATCH_UP_PERIODS)
