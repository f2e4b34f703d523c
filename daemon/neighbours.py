"""What the control loop hears of recorder and supervisor, and shows of itself: mailboxes only, nothing that could wait."""

from __future__ import annotations

from daemon.channels import Channels, RecorderHealth, SupervisorHealth
from daemon.facts import Facts

EVERY_CYCLES = 10  # neighbours change slowly, and the supervisor looks 50 times a second
NEVER_S = 1e9  # age of what was never reported


class Neighbours:
    """The loop's surroundings on the wall clock."""

    def __init__(self, channels: Channels, facts: Facts) -> None:
        self._status = channels.status
        self._recorder, self._supervisor = channels.recorder_health, channels.supervisor_health
        at = facts.index
        self._recorder_age, self._recorder_failed = at("recorder.age_s"), at("recorder.failed")
        self._supervisor_age, self._disk_free = at("supervisor.age_s"), at("disk.free_bytes")
        self._cycle = 0

    def update(self, values: list[float], now_ns: int) -> None:
        if self._cycle % EVERY_CYCLES:
            return
        recorder, supervisor = self._recorder.get(), self._supervisor.get()
        lost, free = 0.0, 0.0
        values[self._supervisor_age] = NEVER_S
        if supervisor is not None:
            lost, free = SupervisorHealth(*supervisor.values)
            values[self._supervisor_age] = (now_ns - supervisor.stamp_ns) * 1e-9
        values[self._disk_free] = free
        values[self._recorder_age], values[self._recorder_failed] = NEVER_S, lost
        if recorder is not None:
            values[self._recorder_age] = (now_ns - recorder.stamp_ns) * 1e-9
            values[self._recorder_failed] = max(lost, RecorderHealth(*recorder.values).failed)

    def publish(self, values: list[float], now_ns: int, urgent: bool) -> None:
        self._cycle += 1
        if urgent or self._cycle % EVERY_CYCLES == 0:
            self._status.put(now_ns, values)
