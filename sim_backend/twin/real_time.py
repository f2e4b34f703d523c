"""A device answers in microseconds whatever else a machine does; a process that plays one asks for real-time priority to come near."""

from __future__ import annotations

import ctypes
import gc
import os

_CURRENT_AND_FUTURE = 1 | 2  # MCL_CURRENT, MCL_FUTURE


def ask_for_real_time(priority: int, cpu: int | None = None) -> str:
    """SCHED_FIFO for this thread and those it starts (0 asks for nothing), one processor only when `cpu` names it, and memory that stays.

    Returns what was granted, for a person.
    """
    gc.collect()
    gc.freeze()  # what exists now stays: a full collection would otherwise walk through it in the middle of a period
    return ", ".join(filter(None, (_scheduler(priority), _processor(cpu), _memory() if priority else "")))


def _scheduler(priority: int) -> str:
    if priority == 0:
        return "ordinary priority"
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError as error:
        return f"ordinary priority (SCHED_FIFO {priority}: {error.strerror})"
    return f"SCHED_FIFO {priority}"


def _processor(cpu: int | None) -> str:
    if cpu is None:
        return ""
    try:
        os.sched_setaffinity(0, {cpu})
    except (OSError, ValueError) as error:
        return f"any processor (processor {cpu}: {error})"
    return f"processor {cpu}"


def _memory() -> str:
    return "" if ctypes.CDLL(None).mlockall(_CURRENT_AND_FUTURE) == 0 else "memory not locked"
