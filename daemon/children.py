"""Starting and ending the daemon's child processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress

from daemon.channels import ChildSpec

MODULES = {"control": "daemon.control_process", "recorder": "daemon.recorder_process", "io": "daemon.io_process"}


class Child:
    """One child process; `name` is control, recorder or io."""

    def __init__(self, name: str, spec: ChildSpec, environment: dict[str, str], inherited: tuple[int, ...]) -> None:
        """`inherited`: descriptors it shall hold besides those of the shared memory."""
        self.name = name
        with os.fdopen(os.memfd_create(f"longreach-{name}"), "w+b") as told:
            told.write(spec.as_json().encode())
            told.seek(0)
            self._process = subprocess.Popen(
                [sys.executable, "-m", MODULES[name]],
                pass_fds=(*spec.descriptors.values(), *inherited),
                env={**os.environ, **environment},
                stdin=told,
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
