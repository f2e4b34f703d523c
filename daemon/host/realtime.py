"""Asks the operating system for real time. A refusal is never fatal: it becomes a fact that the operator sees, with what to do."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
from dataclasses import dataclass
from typing import Any, Protocol

from daemon.host.pm_qos import DEVICE, stay_awake

SWITCH_INTERVAL_S = 1e-4  # should another thread ever run here, it yields after this and not after 5 ms
_MCL_CURRENT, _MCL_FUTURE = 1, 2


class RealtimeWishes(Protocol):
    """Of a rig's `loop` section: SCHED_FIFO priority (0: none) and processor (None: any)."""

    @property
    def priority(self) -> int: ...

    @property
    def cpu(self) -> int | None: ...


@dataclass(frozen=True, slots=True)
class RealtimeFact:
    """One request. `value` is what was got, `next_step` what to do about a refusal (empty when granted)."""

    name: str
    granted: bool
    value: str
    next_step: str = ""

    def row(self) -> dict[str, Any]:
        """As a line of `longreach why`: it warns and does not refuse arming."""
        advice = self.next_step or "-"
        severity = "info" if self.granted else "warning"
        return {
            "name": self.name,
            "ok": True,
            "value": self.value,
            "limit": "",
            "unit": "",
            "source": "host",
            "severity": severity,
            "next_step": advice,
        }


def request_realtime(loop: RealtimeWishes) -> list[RealtimeFact]:
    """For the process that runs the loop, before its first cycle and after everything it needs has been made."""
    return [_scheduler(loop.priority), _affinity(loop.cpu), _idle_states(loop.priority), _lock_memory(), _freeze_garbage_collection()]


def _scheduler(priority: int) -> RealtimeFact:
    name = "real-time priority"
    if priority == 0:
        return RealtimeFact(name, True, "not asked for (loop.priority: 0)")
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except (OSError, ValueError) as error:
        advice = "Run under the systemd unit, or allow it: LimitRTPRIO=99 and CAP_SYS_NICE; in a cgroup see CONFIG_RT_GROUP_SCHED."
        return RealtimeFact(name, False, f"SCHED_FIFO {priority} refused: {_reason(error)}", advice)
    return RealtimeFact(name, True, f"SCHED_FIFO {priority}")


def _affinity(cpu: int | None) -> RealtimeFact:
    name = "processor"
    if cpu is None:
        return RealtimeFact(name, True, "any (loop.cpu not set)")
    try:
        os.sched_setaffinity(0, {cpu})
    except (OSError, ValueError) as error:
        available = ", ".join(map(str, sorted(os.sched_getaffinity(0))))
        return RealtimeFact(name, False, f"processor {cpu} refused: {_reason(error)}", f"Set loop.cpu to one of {available}.")
    return RealtimeFact(name, True, f"pinned to processor {cpu}")


def _idle_states(priority: int) -> RealtimeFact:
    name = "idle states"
    if priority == 0:
        return RealtimeFact(name, True, "left to the system (loop.priority: 0)")
    try:
        stay_awake()
    except OSError as error:
        advice = f"Run under the systemd unit with its udev rules, or give this user write access to {DEVICE}."
        return RealtimeFact(name, False, f"on: {DEVICE}: {_reason(error)}", advice)
    return RealtimeFact(name, True, f"off while this runs ({DEVICE} held at 0)")


def _lock_memory() -> RealtimeFact:
    name = "locked memory"
    if ctypes.CDLL(None, use_errno=True).mlockall(_MCL_CURRENT | _MCL_FUTURE) == 0:
        return RealtimeFact(name, True, "all of it")
    reason = os.strerror(ctypes.get_errno())
    return RealtimeFact(name, False, f"refused: {reason}", "Run under the systemd unit, or raise LimitMEMLOCK (ulimit -l).")


def _freeze_garbage_collection() -> RealtimeFact:
    """No garbage collection in the loop; what exists now is never scanned again."""
    gc.collect()
    gc.freeze()
    gc.disable()
    sys.setswitchinterval(SWITCH_INTERVAL_S)
    return RealtimeFact("interpreter", True, f"gc frozen and off, switch interval {sys.getswitchinterval() * 1e6:.0f} us")


def _reason(error: Exception) -> str:
    return (error.strerror or str(error)) if isinstance(error, OSError) else str(error)
