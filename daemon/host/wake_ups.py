"""Measures whether this machine keeps a rate: a loop that sleeps, spins and works like the daemon's, for some seconds.

    python -m daemon.host.wake_ups < WISHES

It runs in a process of its own, because real-time priority is asked for as the control process does.
"""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from daemon.cycle.clock import WallClock
from daemon.cycle.overrun import PHASES, OverrunPolicy
from daemon.host.realtime import request_realtime

if TYPE_CHECKING:
    from config.schema.rig import Loop

MEASURED_S = 2.0
WORKING = 0.3  # share of a period: a cycle of the simulated testbed at 1 kHz
MARGIN = 0.5  # of what the rig allows: two seconds see less than a minute
_LIMIT_S = 60.0
_TRIALS = 20


@dataclass(frozen=True, slots=True)
class Wishes:
    """What the rig's `loop` section asks for: the same names, and `window_s`, `stop_after` and `fault_late_s` of its overruns."""

    rate_Hz: float
    spin_s: float
    priority: int
    cpu: int | None
    window_s: float
    stop_after: int
    fault_late_s: float
    seconds: float = MEASURED_S


@dataclass(frozen=True, slots=True)
class Machine:
    """What was seen. `late_…_s`: after its deadline a cycle began; `in_window`: most overruns within `window_s`; `largest_s`: how late a
    cycle ended at most."""

    wishes: Wishes
    cycles: int
    late_p50_s: float
    late_p99_s: float
    late_p999_s: float
    largest_s: float
    overruns: int
    in_window: int
    refused: tuple[str, ...]

    @property
    def keeps_rate(self) -> bool:
        return self.in_window < MARGIN * self.wishes.stop_after and self.largest_s < MARGIN * self.wishes.fault_late_s

    def text(self) -> str:
        """What was measured, and what the rig allows; in a second line what the operating system refused."""
        wishes = self.wishes
        many = f"{self.in_window}" if self.in_window <= wishes.stop_after else f"more than {wishes.stop_after}"  # not counted further
        return (
            f"{self.cycles} cycles at {wishes.rate_Hz:.0f} Hz: 99 % began at most {max(self.late_p99_s * 1e6, 1.0):.0f} µs late; "
            f"{self.overruns} overruns, {many} of them within {wishes.window_s:g} s (a run stops at {wishes.stop_after}); at most "
            f"{self.largest_s * 1e3:.1f} ms late (a fault at {wishes.fault_late_s * 1e3:.0f} ms)"
            + ("\n  refused by the operating system: " + "; ".join(self.refused) if self.refused else "")
        )


def measure(loop: Loop, rate_Hz: float | None = None, seconds: float = MEASURED_S) -> Machine:
    """This machine now, with the wishes of a rig's loop, at its rate or another one. Takes `seconds` and the start of a process."""
    over, rate_Hz = loop.overruns, rate_Hz or loop.rate_Hz
    wishes = Wishes(rate_Hz, loop.spin_s, loop.priority, loop.cpu, over.window_s, over.stop_after, over.fault_late_s, seconds)
    command = [sys.executable, "-m", "daemon.host.wake_ups"]
    told = json.dumps(dataclasses.asdict(wishes))
    said = subprocess.run(command, input=told, capture_output=True, text=True, check=True, timeout=_LIMIT_S + seconds).stdout
    found = json.loads(said)
    return Machine(wishes, **{**found, "refused": tuple(found["refused"])})


def main() -> int:
    wishes = Wishes(**json.loads(sys.stdin.read()))
    refused = [f"{fact.name}: {fact.value}" for fact in request_realtime(wishes) if not fact.granted]
    print(json.dumps({**_loop(wishes), "refused": refused}))
    return 0


def _loop(wishes: Wishes) -> dict[str, float]:
    clock, policy = WallClock(wishes.spin_s, 1.0 / wishes.rate_Hz), OverrunPolicy(round(1e9 / wishes.rate_Hz), wishes)
    terms, late, largest_ns, in_window = _terms_of_work(WORKING / wishes.rate_Hz), [], 0, 0
    cycles = round(wishes.seconds * wishes.rate_Hz)
    deadline = clock.now_ns()
    for _ in range(cycles):
        woken = clock.wait_until(deadline)
        late.append(woken - deadline)
        _work(terms)
        ended = clock.now_ns()
        deadline = policy.next_deadline(deadline, ended, [0] * len(PHASES))
        largest_ns = max(largest_ns, policy.late_ns)
        in_window = max(in_window, policy.in_window(ended))
    late.sort()
    p50, p99, p999 = (late[int(share * cycles)] * 1e-9 for share in (0.5, 0.99, 0.999))
    seen = {"cycles": cycles, "late_p50_s": p50, "late_p99_s": p99, "late_p999_s": p999, "largest_s": largest_ns * 1e-9}
    return {**seen, "overruns": policy.overruns, "in_window": in_window}


def _terms_of_work(work_s: float) -> int:
    """So many terms take `work_s` on this processor when nobody interrupts: the quickest of some trials."""
    terms, quickest_s = 1000, float("inf")
    for _ in range(_TRIALS):
        started = time.perf_counter()
        _work(terms)
        quickest_s = min(quickest_s, time.perf_counter() - started)
    return round(terms * work_s / quickest_s)


def _work(terms: int) -> float:
    total = 0.0
    for number in range(terms):
        total += 0.5 * number
    return total


if __name__ == "__main__":
    sys.exit(main())
