"""A process that does nothing else than sleep, at the highest priority of one processor, and writes down when it woke late.

Nothing on the machine may keep it from running, so what it sees late is the machine itself: a virtual machine that its host leaves
waiting. `python pause_watch.py PROCESSOR FILE`: a line for each pause, its begin and end by `time.monotonic`.
"""

from __future__ import annotations

import os
import sys
import time

PERIOD_S = 0.004
# Less happens on machines that keep time; limits of the loops under test begin at 5 ms.
PAUSE_S = 0.008


def watch(processor: int, path: str) -> None:
    os.sched_setaffinity(0, {processor})
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(os.sched_get_priority_max(os.SCHED_FIFO)))
    parent = os.getppid()
    with open(path, "a", buffering=1) as file:
        before = time.monotonic()
        while os.getppid() == parent:
            time.sleep(PERIOD_S)
            now = time.monotonic()
            if now - before > PERIOD_S + PAUSE_S:
                file.write(f"{before} {now}\n")
            before = now


if __name__ == "__main__":
    try:
        watch(int(sys.argv[1]), sys.argv[2])
    except PermissionError:
        sys.exit("real-time priority is not permitted here: pauses of the machine are not watched")
