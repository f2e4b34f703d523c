"""Two clocks for one loop. Wall: absolute deadlines on the monotonic clock, sleep then spin. Lockstep: time is what the loop says.

Measured on a shared virtual machine: a sleep alone wakes 75 us late at the median and 450 us at p99; sleeping until 150 us before
the deadline and spinning the rest 1 us and 25 us, for about 15 % of a core at 1 kHz. A busy or idling host wakes later than that now
and then, for seconds on end; so the spin grows to what the last wake-ups needed and shrinks again (`AdaptiveSpin`).
"""

from __future__ import annotations

import time
from typing import Protocol

LOCKSTEP_START_UNIX_NS = 946_684_800_000_000_000  # 2000-01-01: lockstep logs are the same whenever they are made


class Clock(Protocol):
    """`now_ns` is monotonic. `start_unix_ns` belongs to the instant of `start_ns`, so that logs carry dates."""

    name: str
    start_ns: int
    start_unix_ns: int

    def now_ns(self) -> int: ...

    def wait_until(self, deadline_ns: int) -> int:
        """Returns at the deadline, or at once when it has passed; the result is now_ns() on return."""


class AdaptiveSpin:
    """How long before a deadline to wake up, from how late the last wake-ups were.

    A late one counts at once and is forgotten by a thousandth a cycle, so the spin covers about the latest of a thousand. One later than
    the longest spin is a pause of the machine that no spin would have covered, and counts for nothing: to follow these took an eighth of a
    core more on a busy machine and made no cycle earlier. With `least_ns` 0 there is never a spin: other threads need the interpreter.
    """

    MARGIN = 1.25
    FORGET = 0.999
    MOST_OF_PERIOD = 0.4  # the rest of the core is for the other processes

    def __init__(self, least_ns: float, period_ns: float) -> None:
        self._least = least_ns
        self._most = max(least_ns, self.MOST_OF_PERIOD * period_ns) if least_ns else 0.0
        self._latest = 0.0
        self.ns = least_ns

    def woke(self, late_ns: float) -> None:
        """`late_ns`: after the instant that was slept for."""
        latest = self._latest * self.FORGET
        self._latest = latest = late_ns if latest < late_ns <= self._most else latest
        wanted = self.MARGIN * latest
        self.ns = self._least if wanted < self._least else self._most if wanted > self._most else wanted


class WallClock:
    """Real time. `spin_s`: the least spin before each deadline; `period_s`: between deadlines, of which at most 0.4 is spun."""

    name = "wall"

    def __init__(self, spin_s: float, period_s: float) -> None:
        self._spin = AdaptiveSpin(spin_s * 1e9, period_s * 1e9)
        self.start_ns = time.monotonic_ns()
        self.start_unix_ns = time.time_ns()

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def wait_until(self, deadline_ns: int) -> int:
        monotonic_ns = time.monotonic_ns
        now = monotonic_ns()
        sleep_ns = deadline_ns - self._spin.ns - now
        if sleep_ns > 0:
            wanted = now + sleep_ns
            time.sleep(sleep_ns * 1e-9)
            now = monotonic_ns()
            self._spin.woke(now - wanted)
        while now < deadline_ns:
            now = monotonic_ns()
        return now


class LockstepClock:
    """As fast as possible: waiting moves time to the deadline, nothing else does."""

    name = "lockstep"

    def __init__(self) -> None:
        self.start_ns = 0
        self.start_unix_ns = LOCKSTEP_START_UNIX_NS
        self._now_ns = 0

    def now_ns(self) -> int:
        return self._now_ns

    def wait_until(self, deadline_ns: int) -> int:
        self._now_ns = max(self._now_ns, deadline_ns)
        return self._now_ns
