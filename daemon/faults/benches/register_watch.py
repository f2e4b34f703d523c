"""Samples an output register from outside, as the valves do: when the outputs became safe, and how long they were not renewed.

It knows the register's law and nothing of the loop: what the loop believes or logs has no part in the measured times.
"""

from __future__ import annotations

from daemon.faults.fault import NEVER_MS
from drivers.output_register import OutputRegister

REST_V = 0.1  # a servo that holds writes less than this; one that moves the arm through this test writes more


class RegisterWatch:
    """Call `update` as often as possible from the injection on; times in ms since then."""

    def __init__(self, register: OutputRegister, injected_ns: int) -> None:
        self._register, self._injected_ns = register, injected_ns
        self._timeout_ns = round(register.timeout_s * 1e9)
        self._sequence, self._renewed_ns = register.sequence, injected_ns
        self._safe_since_ns: int | None = None
        self._rest_since_ns: int | None = None
        self.longest_pause_ms = 0.0
        self.timed_out = False  # safe because nobody wrote, not because somebody wrote the safe values

    def update(self, now_ns: int) -> None:
        """Sample what the valves do at `now_ns`."""
        effective = self._register.effective(now_ns)
        values, stamp_ns = self._register.last_write()  # after it: values that are not safe although the valves are have timed out
        self._follow_writes(now_ns)
        if max(map(abs, values), default=0.0) > REST_V:
            self._rest_since_ns = None
        elif self._rest_since_ns is None:
            self._rest_since_ns = now_ns
        if effective != self._register.safe_values:
            self._safe_since_ns = None
        elif self._safe_since_ns is None:
            self.timed_out = values != self._register.safe_values
            self._safe_since_ns = min(now_ns, stamp_ns + self._timeout_ns) if self.timed_out else now_ns

    def _follow_writes(self, now_ns: int) -> None:
        sequence = self._register.sequence
        if sequence == self._sequence:
            return
        self.longest_pause_ms = max(self.longest_pause_ms, (now_ns - self._renewed_ns) * 1e-6)
        self._sequence, self._renewed_ns = sequence, now_ns

    def safe_for_ms(self, now_ns: int) -> float:
        return 0.0 if self._safe_since_ns is None else (now_ns - self._safe_since_ns) * 1e-6

    def rest_for_ms(self, now_ns: int) -> float:
        return 0.0 if self._rest_since_ns is None else (now_ns - self._rest_since_ns) * 1e-6

    @property
    def safe_after_ms(self) -> float:
        return NEVER_MS if self._safe_since_ns is None else max(0.0, (self._safe_since_ns - self._injected_ns) * 1e-6)

    @property
    def rest_after_ms(self) -> float:
        return NEVER_MS if self._rest_since_ns is None else max(0.0, (self._rest_since_ns - self._injected_ns) * 1e-6)
