"""Python imports this in every process of a daemon that is started with this folder on PYTHONPATH, as `benchmarks.loop.soak` does.

The control process then appends the number of its allocated blocks to the file that LONGREACH_BLOCKS names, a line for each SIGUSR1: in its
own thread, between two steps of the loop.
"""

from __future__ import annotations

import os
import signal
import sys


def answer_with_blocks(path: str) -> None:
    """One line for each SIGUSR1."""
    descriptor = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o644)
    signal.signal(signal.SIGUSR1, lambda number, frame: os.write(descriptor, b"%d\n" % sys.getallocatedblocks()) and None)


if "daemon.processes.control_process" in sys.orig_argv and "LONGREACH_BLOCKS" in os.environ:
    answer_with_blocks(os.environ["LONGREACH_BLOCKS"])
