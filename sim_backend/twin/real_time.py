"""A device answers in microseconds whatever else a machine does; a process that plays one asks for real-time priority to come near."""

from __future__ import annotations

import gc
import os


def ask_for_priority(priority: int) -> str:
    """SCHED_FIFO for this thread and those it starts; 0 asks for nothing. Returns what was granted, for a person."""
    gc.freeze()  # what exists now stays: a full collection would otherwise walk through it in the middle of a period
    if priority == 0:
        return "ordinary priority"
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError as error:
        return f"ordinary priority (SCHED_FIFO {priority}: {error.strerror})"
    return f"SCHED_FIFO {priority}"
