"""Who on this machine speaks on a bus or line: a name that the kernel gives to one process and takes back when it ends.

The name is an abstract Unix socket, so it counts in one network namespace, as CAN interfaces and udp_multicast do, and none can be left
over. Linux keeps the serial port itself for one process (pymodbus opens it exclusively); a claim says besides which process has it.
"""

from __future__ import annotations

import errno
import hashlib
import socket
import struct

from config.errors import DriverError

Link = tuple[str, ...]  # as in config.options.device_options.Address
_CREDENTIALS = struct.Struct("3i")  # process, user, group
_WITHIN_ONE_PROCESS = "virtual"  # python-can's interface: no other process can be on it


class LinkClaim:
    """Held from construction to release(). DriverError when another process has the link."""

    def __init__(self, link: Link) -> None:
        self._socket: socket.socket | None = None
        if _WITHIN_ONE_PROCESS in link:
            return
        claim = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            claim.bind(_name(link))
            claim.listen()
        except OSError as error:
            claim.close()
            if error.errno != errno.EADDRINUSE:
                return  # a sandbox without such names: nobody can be asked either
            what = f"another process of longreach speaks on {' '.join(link)}"
            advice = "`longreach status` shows what its daemon reads; stop it (`systemctl stop longreachd`) to ask the devices yourself."
            raise DriverError(what, value=named(holder(link)), where=link[-1], next_step=advice) from error
        self._socket = claim

    def release(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def holder(link: Link) -> int | None:
    """The process that has claimed a link, 0 when it can't be told which; None when nobody has."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as caller:
        caller.setblocking(False)
        try:
            caller.connect(_name(link))
        except BlockingIOError:
            return 0  # it is there, and too many have asked before
        except OSError:
            return None
        process, _, _ = _CREDENTIALS.unpack(caller.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size))
        return int(process)


def _name(link: Link) -> str:
    """An address has no more than 107 bytes."""
    return "\0longreach/" + hashlib.sha256("\0".join(link).encode()).hexdigest()[:32]


def named(process: int | None) -> str:
    """For a sentence."""
    return f"process {process}" if process else "another process"
