"""One daemon a runtime directory: a lock that the kernel releases when its holder dies, so no stale lock can stay."""

from __future__ import annotations

import fcntl
import os
import shlex
import time
from pathlib import Path

from config.errors import DaemonError

LOCK_NAME = "longreachd.lock"
LEFTOVER_LIMIT_S = 10.0  # longer than a controlled stop
POLL_S = 0.05


class RuntimeLock:
    """Held from construction until the last process that has `descriptor` ends; the child processes inherit it.

    Raises DaemonError when another daemon holds it or the directory cannot be used.
    """

    def __init__(self, directory: Path) -> None:
        try:
            directory.mkdir(parents=True, exist_ok=True)
            self.descriptor = os.open(directory / LOCK_NAME, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o640)
        except OSError as error:
            folder = next((each for each in directory.parents if each.is_dir()), directory)
            advice = f"Give a directory this user may write with --runtime-dir: `ls -ld {shlex.quote(str(folder))}` shows who may."
            raise DaemonError(
                "the runtime directory cannot be used", value=error.strerror, where=str(directory), next_step=advice
            ) from error
        limit = time.monotonic() + LEFTOVER_LIMIT_S
        while not self._locked():
            holder = os.pread(self.descriptor, 32, 0).decode(errors="replace").strip()
            if holder.isdigit() and not Path(f"/proc/{holder}").exists() and time.monotonic() < limit:
                time.sleep(POLL_S)  # the daemon died; its control process is still stopping the arm
                continue
            os.close(self.descriptor)
            advice = (
                "Use that daemon (`longreach status`), end it by Ctrl-C in its terminal (a service: `systemctl stop longreachd`), "
                "or give another --runtime-dir."
            )
            raise DaemonError(
                "another daemon uses this runtime directory", value=f"process {holder}", where=str(directory), next_step=advice
            )
        os.ftruncate(self.descriptor, 0)
        os.write(self.descriptor, f"{os.getpid()}\n".encode())

    def _locked(self) -> bool:
        try:
            fcntl.flock(self.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True

    def close(self) -> None:
        os.close(self.descriptor)
