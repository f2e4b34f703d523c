"""Makes every CAN frame of one daemon's processes fail to be sent with ENOBUFS, as a full transmit queue does; switched from outside.

A queue that is full is a state of a driver and its controller, which a bus made of UDP does not have: the error is raised where Python
hands a datagram to the kernel, below python-can and everything of ours.
"""

from __future__ import annotations

import os
from pathlib import Path

# Read by every interpreter that starts with its directory on PYTHONPATH.
_SITE = """
import errno as _errno, mmap as _mmap, os as _os, socket as _socket
from pathlib import Path as _Path
with _Path(__file__).with_name("full").open("r+b") as _file:
    _full = _mmap.mmap(_file.fileno(), 1, access=_mmap.ACCESS_READ)
_sendto = _socket.socket.sendto
def _send(self, *arguments):
    if _full[0]:
        raise OSError(_errno.ENOBUFS, _os.strerror(_errno.ENOBUFS))
    return _sendto(self, *arguments)
_socket.socket.sendto = _send
"""


def environment(directory: Path) -> dict[str, str]:
    """For the daemon's start."""
    site = directory / "full-queue"
    site.mkdir()
    (site / "full").write_bytes(b"\0")
    (site / "sitecustomize.py").write_text(_SITE)
    return {"PYTHONPATH": os.pathsep.join(filter(None, (str(site), os.environ.get("PYTHONPATH", ""))))}


def switch(directory: Path, is_full: bool) -> None:
    """From now on the daemon's processes can send no datagram, or can again."""
    with (directory / "full-queue" / "full").open("r+b") as file:
        file.write(b"\1" if is_full else b"\0")
