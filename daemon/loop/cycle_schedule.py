"""When the next cycle begins, and how long each phase of the last one took."""

from __future__ import annotations

from daemon.cycle.overrun import PHASES, OverrunPolicy
from daemon.cycle.timing import QUANTITIES, Timing

_WORK = QUANTITIES.index("work")


class CycleSchedule:
    """`deadline_ns` of the next cycle; `phases_ns` of the last one, in the order of PHASES. Times in ns of the loop's clock.

    Set `activated` in a cycle that activates devices or sets them up: it may take long, outputs are safe, and it is no overrun.
    """

    def __init__(self, overruns: OverrunPolicy, timing: Timing, start_ns: int) -> None:
        self._overruns, self._timing = overruns, timing
        self.phases_ns = [0] * len(PHASES)
        self.activated = False
        self.begin(start_ns)

    def begin(self, deadline_ns: int) -> None:
        """The first deadline."""
        self.deadline_ns = self._end_ns = deadline_ns

    def end(self, started: int, read: int, checked: int, computed: int, written: int, recorded: int, ended: int) -> None:
        """The instants at which the phases of a cycle ended, `started` being the end of the wait; sets the next deadline."""
        deadline = self.deadline_ns
        self.phases_ns[:] = (
            started - max(deadline, self._end_ns),
            read - started,
            checked - read,
            computed - checked,
            written - computed,
            recorded - written,
            ended - recorded,
        )
        self._timing.count(_WORK, (ended - started) * 1e-3)
        self._end_ns = ended
        if self.activated:
            self.activated = False
            self.deadline_ns = self._overruns.deadline_after_activation(deadline, ended)
        else:
            self.deadline_ns = self._overruns.next_deadline(deadline, ended, self.phases_ns)
