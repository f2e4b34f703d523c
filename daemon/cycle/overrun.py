"""The overrun policy: what the loop does when a cycle ends after the next one should have begun.

late by less than a period    the next cycle runs at once and its lateness is recorded
late by whole periods         these cycles are skipped; the phase of the deadlines is kept
`stop_after` in `window_s`    controlled stop (interlock "loop timing")
later than `fault_late_s`     fault (interlock "loop stall")

Time in the controller is executed cycles × period, so a skipped period slows the motion down and never makes it jump.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Protocol

PHASES = ("wait", "read", "checks", "compute", "write", "record", "spare")


class Window(Protocol):
    """Of a rig's `loop.overruns` section: the window in which `stop_after` overruns stop a run."""

    @property
    def window_s(self) -> float: ...

    @property
    def stop_after(self) -> int: ...


class OverrunPolicy:
    """Counts overruns by kind and by culprit, and gives the next deadline. Times in ns."""

    def __init__(self, period_ns: int, limits: Window) -> None:
        self._period_ns = period_ns
        self._window_ns = round(limits.window_s * 1e9)
        self._recent: deque[int] = deque(maxlen=limits.stop_after + 1)
        self.overruns = 0
        self.missed_periods = 0
        self.by_culprit = dict.fromkeys(PHASES, 0)
        self.culprit = ""  # of the last overrun
        self.late_ns = 0  # of the last cycle: how long after the next deadline it ended; 0 when it was in time
        self.missed = 0  # periods skipped after the last cycle

    def next_deadline(self, deadline_ns: int, end_ns: int, phases_ns: Sequence[int]) -> int:
        """The cycle of `deadline_ns` ended at `end_ns` after phases of these lengths (in the order of PHASES)."""
        following = deadline_ns + self._period_ns
        late = end_ns - following
        if late <= 0:
            self.late_ns = self.missed = 0
            return following
        self.late_ns = late
        self.missed = late // self._period_ns
        self.overruns += 1
        self.missed_periods += self.missed
        self.culprit = slowest_phase(phases_ns)
        self.by_culprit[self.culprit] += 1
        self._recent.append(end_ns)
        return following + self.missed * self._period_ns

    def deadline_after_activation(self, deadline_ns: int, end_ns: int) -> int:
        """The next deadline after a cycle that activated devices, with outputs safe: it may take long and is no overrun."""
        self.late_ns = self.missed = 0
        late = max(0, end_ns - deadline_ns - self._period_ns)
        return deadline_ns + self._period_ns * (1 + -(-late // self._period_ns))

    def in_window(self, now_ns: int) -> int:
        """Overruns in the window that ends now; counted no further than one above the limit."""
        recent = self._recent
        while recent and now_ns - recent[0] > self._window_ns:
            recent.popleft()
        return len(recent)


def slowest_phase(phases_ns: Sequence[int]) -> str:
    """Name of the longest phase; `wait` means that the operating system woke the loop late."""
    return PHASES[max(range(len(PHASES)), key=phases_ns.__getitem__)]
