"""Follows one run from its request to its verdict: countdown, elapsed time, and why it is not valid if it is not."""

from __future__ import annotations

from enum import IntEnum
from math import ceil

from servo_control.signals import Mode

MISSED = "periods were missed"
MISSED_SHARE_LIMIT = 0.05  # a run that misses more of its periods is no evidence of what the servo can do


class RunVerdict(IntEnum):
    """As published; NONE before the first run."""

    NONE = 0
    RUNNING = 1
    VALID = 2
    INVALID = 3


class RunWatch:
    """The run that was asked for last. Times in executed cycles; `number` 0 before the first."""

    def __init__(self, period_s: float) -> None:
        self._period_s = period_s
        self.number = 0
        self.verdict = RunVerdict.NONE
        self.reason = ""
        self.countdown_cycles = 0
        self.elapsed_cycles = 0
        self.duration_s = 0.0
        self._missed_before = 0

    def request(self, number: int, duration_s: float, countdown_s: float) -> None:
        self.number, self.duration_s = number, duration_s
        self.verdict, self.reason = RunVerdict.RUNNING, ""
        self.countdown_cycles = max(1, ceil(countdown_s / self._period_s))
        self.elapsed_cycles = 0

    @property
    def active(self) -> bool:
        """Counting down or under way."""
        return self.verdict is RunVerdict.RUNNING

    @property
    def number_for_controller(self) -> int:
        return self.number if self.active else 0

    def count_down(self) -> int | None:
        """One cycle of announcement: seconds left when a whole second begins (0: start now), else None."""
        self.countdown_cycles -= 1
        left_s = self.countdown_cycles * self._period_s
        whole = round(left_s)
        return whole if abs(left_s - whole) < 0.5 * self._period_s else None

    def begin(self, missed_periods: int) -> None:
        self.countdown_cycles = 0
        self._missed_before = missed_periods

    def invalidate(self, reason: str) -> None:
        """The run is not valid. The first reason counts: what follows is its consequence."""
        if self.active and not self.reason:
            self.reason = reason

    def follow(self, mode: Mode, missed_periods: int) -> bool:
        """One cycle in `mode`; True in the cycle in which the run ends."""
        if not self.active or (self.countdown_cycles > 0 and mode is Mode.HOLDING):
            return False
        if mode in (Mode.RUNNING, Mode.STOPPING):
            self.elapsed_cycles += 1
            return False
        if mode is not Mode.HOLDING:
            self.invalidate(f"the daemon went to {mode.name.lower()}")
        self._judge_timing(missed_periods - self._missed_before)
        self.end()
        return True

    def end(self) -> None:
        self.verdict = RunVerdict.INVALID if self.reason else RunVerdict.VALID
        self.countdown_cycles = 0

    def _judge_timing(self, missed: int) -> None:
        if missed > MISSED_SHARE_LIMIT * max(1, self.elapsed_cycles):
            share = f"{missed} of {self.elapsed_cycles + missed} {MISSED}"
            self.invalidate(f"{share} (limit {MISSED_SHARE_LIMIT:.0%}); see the timing passport for the slowest phase")
