"""Faults from another process: one JSON object a datagram on a Unix socket, answered with one JSON object.

{"do": "inject", "device": NAME, "fault": NAME, "amount": NUMBER}, {"do": "clear"} or {"do": "clear", "device": NAME}, and
{"do": "describe"}. The answer has `ok`, `now_ns` (monotonic clock, the same in all processes of this machine) and what was asked
for, or `error`. Datagrams, because the twin looks for them between two frames and never waits.
"""

from __future__ import annotations

import itertools
import json
import os
import socket
from contextlib import suppress
from pathlib import Path
from typing import Any

from config.errors import LongreachError, PlantError
from config.socket_place import in_the_way

_LARGEST = 65536
_numbers = itertools.count()


class ControlSocket:
    """The twin's end; never blocks."""

    def __init__(self, path: Path) -> None:
        self._path = path
        _remove_leftover(path)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK)
        self._socket.bind(str(path))
        self._inode = path.stat().st_ino

    def request(self) -> tuple[dict[str, Any], str] | None:
        """The next request and who asks; None when there is none. Datagrams that are no JSON object are dropped."""
        try:
            data, sender = self._socket.recvfrom(_LARGEST)
            content = json.loads(data)
        except (BlockingIOError, InterruptedError, ValueError, RecursionError):
            return None
        return (content, sender) if isinstance(content, dict) and sender else None

    def answer(self, sender: str, content: dict[str, Any]) -> None:
        try:
            self._socket.sendto(json.dumps(content).encode(), sender)
        except OSError:
            return  # whoever asked has gone

    def close(self) -> None:
        self._socket.close()
        with suppress(FileNotFoundError):
            if self._path.stat().st_ino == self._inode:
                self._path.unlink()


def _remove_leftover(path: Path) -> None:
    """The socket of a twin that was killed makes room. PlantError for a file, and for one at which a twin listens."""
    there, advice = in_the_way(path, socket.SOCK_DGRAM), "Give another place with --control."
    if there == "a file":
        raise PlantError("the control socket's place is taken by a file", where=str(path), next_step=advice)
    if there:
        raise PlantError("another twin has this control socket", where=str(path), next_step=advice)


class TwinControl:
    """The other end, for tests and the fault matrix."""

    def __init__(self, path: Path, timeout_s: float = 2.0) -> None:
        self._twin = str(path)
        self._own = Path(f"{path}.{os.getpid()}.{next(_numbers)}")
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(self._own))
        self._socket.settimeout(timeout_s)

    def inject(self, device: str, fault: str, amount: float = 0.0) -> int:
        """Start a fault; returns when it began (monotonic ns). PlantError when there is no such device or fault."""
        return int(self._ask({"do": "inject", "device": device, "fault": fault, "amount": amount})["now_ns"])

    def clear(self, device: str | None = None) -> None:
        """End the faults of one device, or of all."""
        self._ask({"do": "clear"} | ({"device": device} if device else {}))

    def describe(self) -> dict[str, Any]:
        """Device → its state; also `plant`."""
        devices: dict[str, Any] = self._ask({"do": "describe"})["devices"]
        return devices

    def close(self) -> None:
        self._socket.close()
        self._own.unlink(missing_ok=True)

    def _ask(self, content: dict[str, Any]) -> dict[str, Any]:
        try:
            self._socket.sendto(json.dumps(content).encode(), self._twin)
            answer: dict[str, Any] = json.loads(self._socket.recv(_LARGEST))
        except OSError as error:
            raise PlantError(
                "the twin does not answer", value=str(error), where=self._twin, next_step="Is `longreach twin` running?"
            ) from error
        if not answer.get("ok"):
            raise PlantError(str(answer.get("error")))
        return answer


def obey(bench: Any, request: dict[str, Any], now_ns: int) -> dict[str, Any]:
    """Do what a request says to the bench; returns the answer."""
    try:
        return {"ok": True, "now_ns": now_ns, **_done(bench, request)}
    except (LongreachError, TypeError, ValueError) as error:
        return {"ok": False, "now_ns": now_ns, "error": str(error)}


def _done(bench: Any, request: dict[str, Any]) -> dict[str, Any]:
    verb = request.get("do")
    if verb == "inject":
        bench.device(str(request.get("device"))).inject(str(request.get("fault")), float(request.get("amount", 0.0)))
    elif verb == "clear":
        names = [str(request["device"])] if "device" in request else list(bench.devices)
        for name in names:
            bench.device(name).clear()
    elif verb == "describe":
        return {"devices": bench.describe()}
    else:
        raise PlantError("unknown request", value=verb, limit="inject, clear, describe")
    return {}
