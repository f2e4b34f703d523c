"""A child process that hears of its parent's death, even by SIGKILL: Linux sends it a signal."""

from __future__ import annotations

import ctypes
import os
import signal

_PR_SET_PDEATHSIG = 1


def signal_on_parent_death(parent_pid: int, number: signal.Signals = signal.SIGTERM) -> None:
    """Call first thing in the child. A parent that is gone already counts as dying now."""
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, int(number), 0, 0, 0)
    if os.getppid() != parent_pid:
        os.kill(os.getpid(), number)
