"""Runs inside the service's sandbox, as its user: tries things and prints how each ended, as one JSON object.

"done", or the name of the error number. Where an ordinary user is allowed a thing, or is refused it with another error, the answer
tells that it is the sandbox that speaks.
"""

from __future__ import annotations

import ctypes
import errno
import json
import mmap
import os
import socket
from collections.abc import Callable
from pathlib import Path

CLONE_NEWUSER = 0x10000000
PER_LINUX32 = 0x0008
LIBC = ctypes.CDLL(None, use_errno=True)


def outcome(attempt: Callable[[], object]) -> str:
    try:
        attempt()
    except OSError as error:
        return errno.errorcode.get(error.errno or 0, str(error))
    return "done"


def call(name: str, *arguments: int) -> None:
    if getattr(LIBC, name)(*arguments) == -1:
        raise OSError(ctypes.get_errno(), name)


def write(directory: str) -> Callable[[], object]:
    return lambda: Path(directory, "probe").write_text("x")


def own(variable: str) -> Callable[[], object]:
    return write(os.environ[variable])


def open_socket(family: int, kind: int) -> Callable[[], object]:
    return lambda: socket.socket(family, kind).close()


def main() -> None:
    executable = mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC
    attempts: dict[str, Callable[[], object]] = {
        "write /etc/longreach": write("/etc/longreach"),
        "write /opt/longreach": write("/opt/longreach"),
        "write /usr": write("/usr"),
        "write logs": own("LOGS_DIRECTORY"),
        "write cache": own("CACHE_DIRECTORY"),
        "write runtime": own("RUNTIME_DIRECTORY"),
        "write tmp": write("/tmp"),
        "see outside tmp": lambda: Path("/tmp/outside").stat(),
        "list home": lambda: os.listdir("/home"),
        "see process 1": lambda: Path("/proc/1/cmdline").read_bytes(),
        "socket AF_UNIX": open_socket(socket.AF_UNIX, socket.SOCK_STREAM),
        "socket AF_INET": open_socket(socket.AF_INET, socket.SOCK_STREAM),
        "socket AF_PACKET": open_socket(socket.AF_PACKET, socket.SOCK_RAW),
        "socket AF_NETLINK": open_socket(socket.AF_NETLINK, socket.SOCK_RAW),
        "user namespace": lambda: call("unshare", CLONE_NEWUSER),
        "change personality": lambda: call("personality", PER_LINUX32),
        "set-group-id file": lambda: os.chmod(Path(os.environ["CACHE_DIRECTORY"], "probe"), 0o2700),
        "become root": lambda: os.setuid(0),
        "SCHED_FIFO": lambda: os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(80)),
        "lock memory": lambda: call("mlockall", 3),
        "executable memory": lambda: mmap.mmap(-1, 4096, prot=executable).close(),
    }
    print(json.dumps({name: outcome(attempt) for name, attempt in attempts.items()}))


if __name__ == "__main__":
    main()
