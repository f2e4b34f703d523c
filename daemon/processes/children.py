"""Starting and ending the daemon's child processes; and how a child hears of its parent's death, even by SIGKILL."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
from contextlib import suppress

from daemon.processes.channels import ChildSpec

_PR_SET_PDEATHSIG = 1

MODULES = {
    "control": "daemon.processes.control_process",
    "recorder": "daemon.processes.recorder_process",
    "io": "daemon.processes.io_process",
}


class Child:
    """One child process; `name` is control, recorder or io."""

    def __init__(self, name: str, spec: ChildSpec, environment: dict[str, str], inherited: tuple[int, ...]) -> None:
        """`inherited`: descriptors that it holds besides those of the shared memory."""
        self.name = name
        with os.fdopen(os.memfd_create(f"longreach-{name}"), "w+b") as spec_file:
            spec_file.write(spec.as_bytes())
            spec_file.seek(0)
            self._process = subprocess.Popen(
                [sys.executable, "-m", MODULES[name]],
                pass_fds=(*spec.descriptors.values(), *inherited),
                env={**os.environ, **environment},
                stdin=spec_file,
            )

    @property
    def pid(self) -> int:
        return self._process.pid

    def ended(self) -> bool:
        return self._process.poll() is not None

    def how_it_ended(self) -> str:
        """For a message: exit status or signal."""
        status = self._process.poll()
        if status is None:
            return "running"
        return f"exit status {status}" if status >= 0 else f"killed by {signal.Signals(-status).name}"

    def terminate(self) -> None:
        with suppress(ProcessLookupError):
            self._process.terminate()

    def kill(self) -> None:
        with suppress(ProcessLookupError):
            self._process.kill()


def leave_terminal_to_supervisor() -> None:
    """Ctrl-C and the end of a terminal reach every process of the daemon at once, and must stop the arm in order: the supervisor sees to
    that."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)


def signal_on_parent_death(parent_pid: int, number: signal.Signals = signal.SIGTERM) -> None:
    """Call first thing in the child: Linux then sends it this signal. A parent that is gone already counts as dying now."""
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, int(number), 0, 0, 0)
    if os.getppid() != parent_pid:
        os.kill(os.getpid(), number)
