"""Python imports this in every process of a daemon that is started with this folder on PYTHONPATH, as `benchmarks.loop.soak` does.

In the control process every record's way into the ring is then timed, and each SIGUSR1 appends a line to the file that LONGREACH_COUNTS
names: allocated blocks, and the p50 and p99 of those times in us. In its own thread, between two steps of the loop.
"""

from __future__ import annotations

import os
import signal
import sys
from array import array
from time import perf_counter_ns

KEPT = 20_000  # of the latest cycles


def answer_with_counts(path: str) -> None:
    """One line for each SIGUSR1."""
    from daemon.cycle.log_stream import LogStream

    hand_over, times, count = LogStream.cycle, array("q", bytes(8 * KEPT)), 0

    def timed(log: LogStream, values: list[float]) -> None:
        nonlocal count
        began = perf_counter_ns()
        hand_over(log, values)
        times[count % KEPT] = perf_counter_ns() - began
        count += 1

    def answer(number: int, frame: object) -> None:
        blocks, latest = sys.getallocatedblocks(), sorted(times[: min(count, KEPT)]) or [0]
        p50, p99 = (latest[int(share * len(latest))] * 1e-3 for share in (0.5, 0.99))
        os.write(descriptor, f"{blocks} {p50} {p99}\n".encode())

    descriptor = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o644)
    LogStream.cycle = timed  # type: ignore[method-assign]
    signal.signal(signal.SIGUSR1, answer)


if "daemon.processes.control_process" in sys.orig_argv and "LONGREACH_COUNTS" in os.environ:
    answer_with_counts(os.environ["LONGREACH_COUNTS"])
