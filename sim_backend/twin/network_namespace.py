"""A network namespace in which multicast stays on the loopback device, so that udp_multicast cannot leak onto a real network.

python-can's udp_multicast follows the default route: on a plain host a test works while its frames leave through the network card.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

from config.errors import PlantError
from config.options.multicast import EXAMPLE_GROUP

CLONE_NEWNET = 0x40000000
GROUP = EXAMPLE_GROUP
_libc = ctypes.CDLL(None, use_errno=True)


class NetworkNamespace:
    """`prefix` runs a command inside; `entered()` moves the calling thread inside, and what it opens there stays there.

    Raises PlantError that says why this computer or user cannot make one.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.prefix = ["ip", "netns", "exec", name]
        _ip("netns", "add", name)
        try:
            for command in (
                ["link", "set", "lo", "up"],
                ["link", "set", "lo", "multicast", "on"],
                ["route", "add", "224.0.0.0/4", "dev", "lo"],
            ):
                _ip("-n", name, *command)
            self._refuse_a_leak()
        except BaseException:
            self.delete()
            raise

    @contextlib.contextmanager
    def entered(self) -> Iterator[None]:
        home = os.open(f"/proc/self/task/{threading.get_native_id()}/ns/net", os.O_RDONLY)
        try:
            _set_namespace(Path("/run/netns") / self.name)
            yield
        finally:
            _libc.setns(home, CLONE_NEWNET)
            os.close(home)

    def delete(self) -> None:
        subprocess.run(["ip", "netns", "delete", self.name], capture_output=True, check=False)

    def _refuse_a_leak(self) -> None:
        route = subprocess.run([*self.prefix, "ip", "route", "get", GROUP], capture_output=True, text=True, check=False)
        if " dev lo " not in route.stdout:
            raise _impossible(f"multicast would not stay on lo: {route.stdout or route.stderr}")


def _ip(*arguments: str) -> None:
    try:
        result = subprocess.run(["ip", *arguments], capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise _impossible("the command `ip` (iproute2) is not installed") from None
    if result.returncode:
        raise _impossible(f"ip {' '.join(arguments)}: {result.stderr.strip()}")


def _set_namespace(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        if _libc.setns(descriptor, CLONE_NEWNET):
            raise _impossible(f"setns: {os.strerror(ctypes.get_errno())}")
    finally:
        os.close(descriptor)


def _impossible(why: str) -> PlantError:
    return PlantError("no network namespace can be made", value=why, next_step="Run as root, with iproute2 installed.")
