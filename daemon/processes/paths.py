"""Where the daemon keeps its socket, its shared memory and its logs unless an option or the environment says otherwise."""

from __future__ import annotations

import os
from pathlib import Path

SERVICE_RUNTIME_DIRECTORY = Path("/run/longreach")


def runtime_directory(chosen: str | os.PathLike[str] | None = None) -> Path:
    """The chosen directory, the service's (systemd's RuntimeDirectory=) where it exists, or one of this user's."""
    if chosen:
        return Path(chosen)
    from_systemd = os.environ.get("RUNTIME_DIRECTORY")
    if from_systemd:
        return Path(from_systemd)
    if SERVICE_RUNTIME_DIRECTORY.is_dir():
        return SERVICE_RUNTIME_DIRECTORY
    user_runtime = os.environ.get("XDG_RUNTIME_DIR")
    return Path(user_runtime) / "longreach" if user_runtime else Path(f"/tmp/longreach-{os.getuid()}")


def socket_path(chosen: str | os.PathLike[str] | None = None) -> Path:
    """The chosen socket, $LONGREACH_SOCKET, or `longreach.sock` in the runtime directory."""
    return Path(chosen or os.environ.get("LONGREACH_SOCKET") or runtime_directory() / "longreach.sock")


def log_directory(chosen: str | os.PathLike[str] | None = None) -> Path:
    """The chosen directory, systemd's LogsDirectory=, or ./logs."""
    return Path(chosen or os.environ.get("LOGS_DIRECTORY") or "logs")
