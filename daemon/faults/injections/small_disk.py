"""A small file system of its own for the logs of one trial, and ballast to fill it. Needs the right to mount."""

from __future__ import annotations

import subprocess
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from config.errors import DaemonError

SIZE_MB = 48
LEAST_FREE_MB = 16
_CHUNK = bytes(1 << 16)


def mounted(directory: Path) -> Path:
    """Mount it in `directory`; returns where logs go."""
    mount_point = directory / "small"
    mount_point.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={SIZE_MB}m", "longreach-faults", str(mount_point)]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise DaemonError("a file system for a full disk cannot be mounted", value=str(error), next_step="Run as root.") from error
    return mount_point


def unmount(directory: Path) -> None:
    """Also while a process has a file open there."""
    with suppress(OSError):
        subprocess.run(["umount", "-l", str(directory / "small")], capture_output=True, check=False)


def fill(directory: Path, leave_MB: int) -> None:
    """Write ballast until only `leave_MB` are free; 0: until nothing more can be written."""
    wanted = (SIZE_MB - leave_MB) << 20
    with (directory / "small" / "ballast").open("wb", buffering=0) as ballast, suppress(OSError):
        while ballast.tell() < wanted or not leave_MB:
            ballast.write(_CHUNK)


@cache
def possible() -> bool:
    """Whether this user may mount."""
    with TemporaryDirectory(prefix="longreach-faults-") as directory:
        try:
            mounted(Path(directory))
        except DaemonError:
            return False
        unmount(Path(directory))
        return True
