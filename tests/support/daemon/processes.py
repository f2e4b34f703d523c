"""Processes by /proc: children with their modules, alive or not, kill by id."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from pathlib import Path


def children(parent: int) -> dict[str, int]:
    """module → process id of every `python -m MODULE` child of `parent`."""
    found = {}
    for directory in Path("/proc").iterdir():
        if not directory.name.isdigit():
            continue
        with suppress(OSError, IndexError):
            status = (directory / "stat").read_text()
            if int(status.rpartition(")")[2].split()[1]) == parent:
                words = (directory / "cmdline").read_bytes().split(b"\0")
                found[words[words.index(b"-m") + 1].decode() if b"-m" in words else words[0].decode()] = int(directory.name)
    return found


def is_alive(pid: int) -> bool:
    """Running; a zombie that its parent has not fetched counts as dead."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def kill(pid: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)
