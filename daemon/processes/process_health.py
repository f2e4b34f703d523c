"""Health of recorder and supervisor for the loop, and the loop's facts for them: mailboxes only, nothing that could wait."""

from __future__ import annotations

from daemon.cycle.facts import Facts
from daemon.processes.channels import Channels, RecorderHealth, SupervisorHealth

EVERY_S = 0.01  # their health changes slowly, and the supervisor polls 50 times a second
NEVER_S = 1e9  # age of what was never reported


class MailboxHealth:
    """Health of the other processes on the wall clock: see daemon.loop.other_processes.ProcessHealth."""

    def __init__(self, channels: Channels, facts: Facts, rate_Hz: float) -> None:
        self._status = channels.status
        self._recorder, self._supervisor = channels.recorder_health, channels.supervisor_health
        at = facts.index
        self._recorder_age, self._recorder_failed = at("recorder.age_s"), at("recorder.failed")
        self._supervisor_age, self._disk_free, self._host_rate = at("supervisor.age_s"), at("disk.free_bytes"), at("host.rate_Hz")
        self._cycle, self._every = 0, max(1, round(EVERY_S * rate_Hz))

    def update(self, values: list[float], now_ns: int) -> None:
        if self._cycle % self._every:
            return
        recorder, supervisor = self._recorder.get(), self._supervisor.get()
        lost, free, rate_Hz = 0.0, 0.0, 0.0
        values[self._supervisor_age] = NEVER_S
        if supervisor is not None:
            lost, free, rate_Hz = SupervisorHealth(*supervisor.values)
            values[self._supervisor_age] = (now_ns - supervisor.stamp_ns) * 1e-9
        values[self._disk_free], values[self._host_rate] = free, rate_Hz
        values[self._recorder_age], values[self._recorder_failed] = NEVER_S, lost
        if recorder is not None:
            values[self._recorder_age] = (now_ns - recorder.stamp_ns) * 1e-9
            values[self._recorder_failed] = max(lost, RecorderHealth(*recorder.values).failed)

    def publish(self, values: list[float], now_ns: int, urgent: bool) -> None:
        self._cycle += 1
        if urgent or self._cycle % self._every == 0:
            self._status.put(now_ns, values)
