"""The place of a Unix socket that is to be made: what stands there."""

from __future__ import annotations

import socket
import stat
from contextlib import suppress
from pathlib import Path
from typing import Literal


def in_the_way(path: Path, kind: socket.SocketKind) -> Literal["", "a file", "a listener"]:
    """What keeps a socket of this kind from being made. One on which nobody listens was left by a killed process: it is removed."""
    with suppress(FileNotFoundError):
        if not stat.S_ISSOCK(path.lstat().st_mode):
            return "a file"
        with socket.socket(socket.AF_UNIX, kind) as asking:
            try:
                asking.connect(str(path))
            except ConnectionRefusedError:
                path.unlink()
                return ""
            except PermissionError:
                pass  # somebody else's, who may listen
        return "a listener"
    return ""
