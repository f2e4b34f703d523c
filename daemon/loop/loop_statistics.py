"""The loop's numbers about itself, put into the facts: which cycle it is, how long its phases took, what was lost, how the run stands.

And the event about an overrun, with its culprit; more than a few a second are only counted.
"""

from __future__ import annotations

from collections.abc import Sequence

from daemon.cycle.facts import Facts
from daemon.cycle.log_stream import LogStream
from daemon.cycle.overrun import PHASES, OverrunPolicy
from daemon.cycle.timing import Timing
from daemon.modes.run_watch import RunWatch
from recording.format.event import Level

OVERRUN_EVENTS_PER_S = 5.0


class LoopStatistics:
    """Indices are looked up once; every method writes into the `values` of the cycle under way."""

    def __init__(self, facts: Facts, log: LogStream, overruns: OverrunPolicy, timing: Timing, period_s: float) -> None:
        self._log, self._overruns, self._timing, self._period_s = log, overruns, timing, period_s
        at = facts.index
        self._at_cycle, self._at_t = at("cycle"), at("t_s")
        self._at_times = tuple(map(at, ("late_us", "read_us", "compute_us", "write_us")))
        self._at_counts = tuple(map(at, ("overruns", "drops", "recorder.drops", "loop.overruns_in_window", "commands", "loop.late_s")))
        self._at_run = tuple(map(at, ("run.number", "run.countdown_s", "run.elapsed_s", "run.duration_s", "run.verdict")))
        self._overrun_logged_ns = 0

    def begin_cycle(self, values: list[float], since_start_ns: int, start_unix_ns: int) -> None:
        """The cycle whose deadline was `since_start_ns` after the loop's start; the log stamps with it."""
        log = self._log
        values[self._at_cycle] += 1
        values[self._at_t] = log.t_s = since_start_ns * 1e-9
        log.cycle_number = int(values[self._at_cycle])
        log.now_ns = start_unix_ns + since_start_ns

    def count(self, values: list[float], commands_done: int, now_ns: int) -> None:
        """Losses so far."""
        overruns, log = self._overruns, self._log
        in_window = overruns.in_window(now_ns)
        counts = (overruns.overruns, log.drops, log.drops_in_recording, in_window, commands_done, overruns.late_ns * 1e-9)
        for index, count in zip(self._at_counts, counts, strict=True):
            values[index] = count

    def measure(self, values: list[float], *lengths_ns: int) -> None:
        """Lateness and the lengths of reading, computing and writing: into the row and the histograms."""
        for quantity, (index, length) in enumerate(zip(self._at_times, lengths_ns, strict=True)):
            values[index] = length_us = length * 1e-3
            self._timing.count(quantity, length_us)

    def put_run(self, values: list[float], run: RunWatch) -> None:
        """Countdown, elapsed time and verdict."""
        period_s = self._period_s
        facts = (run.number, run.countdown_cycles * period_s, run.elapsed_cycles * period_s, run.duration_s, run.verdict)
        for index, value in zip(self._at_run, facts, strict=True):
            values[index] = value

    def log_overrun(self, phases_ns: Sequence[int], now_ns: int) -> None:
        """Of the cycle that has just ended."""
        overruns = self._overruns
        if not overruns.late_ns or now_ns - self._overrun_logged_ns < 1e9 / OVERRUN_EVENTS_PER_S:
            return
        self._overrun_logged_ns = now_ns
        slowest = phases_ns[PHASES.index(overruns.culprit)] * 1e-3
        late_ms = overruns.late_ns * 1e-6
        text = f"cycle ended {late_ms:.3f} ms late, {overruns.missed} periods missed; slowest: {overruns.culprit} {slowest:.0f} us"
        numbers = {"late_ms": late_ms, "missed": overruns.missed, "slowest_us": slowest, "overruns": overruns.overruns}
        self._log.event(Level.WARNING, "overrun", text, numbers)
