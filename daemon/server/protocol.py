"""The daemon's protocol: one JSON object a line, both ways, over a Unix socket.

Request   {"v": 1, "id": 7, "method": "start", "params": {...}}
Answer    {"id": 7, "result": {...}}   or   {"id": 7, "error": {"class": "DaemonError", "what": ..., "value": ..., "next_step": ...}}

A line that is no request is answered with an error and id null; the connection stays open. A line longer than MAX_LINE_BYTES is
answered and the connection closed, because its end cannot be found. A number that is not finite travels as null.
"""

from __future__ import annotations

import json
import math
import shlex
import socket
from dataclasses import dataclass
from os import PathLike
from types import TracebackType
from typing import Any

from config import errors
from config.errors import DaemonError, LongreachError

VERSION = 1
MAX_LINE_BYTES = 1 << 20
DEFAULT_TIMEOUT_S = 30.0
LONGEST_COUNTDOWN_S, LONGEST_SETTLE_S = 60.0, 600.0  # before a motion: of its announcement, of waiting for rest
_LONGER_S = {"prove": 50.0, "reset": 10.0}  # a rig's longest countdown and all proofs; a recorder and all devices set up anew
_WAITS = ("timeout_s", "settle_s", "countdown_s")  # parameters by which an answer comes later

RequestId = str | int | None


@dataclass(frozen=True, slots=True)
class Request:
    """One request as the server sees it."""

    id: RequestId
    method: str
    params: dict[str, Any]


def encode(message: dict[str, Any]) -> bytes:
    """One line. Numbers that are not finite become null."""
    try:
        return json.dumps(message, allow_nan=False, separators=(",", ":")).encode() + b"\n"
    except ValueError:
        return json.dumps(_finite(message), allow_nan=False, separators=(",", ":")).encode() + b"\n"


def parse_request(line: bytes) -> Request:
    """The request in `line`. Raises DaemonError that says what is wrong with it."""
    message = json_object(line)
    if message.get("v") != VERSION:
        raise DaemonError("unknown protocol version", value=message.get("v"), limit=VERSION, next_step='Send {"v": 1, ...}.')
    method, params, request_id = message.get("method"), message.get("params", {}), message.get("id")
    if not isinstance(method, str) or not isinstance(params, dict):
        raise DaemonError("a request needs a method (text) and params (object)", next_step='Example: {"v":1,"id":1,"method":"status"}.')
    if not (request_id is None or isinstance(request_id, (str, int))):
        raise DaemonError("a request's id must be a text or a whole number", value=type(request_id).__name__)
    return Request(request_id, method, params)


def request_id_of(line: bytes) -> RequestId:
    """The id of a line even when the rest of it is wrong; None when it has none."""
    try:
        request_id = json_object(line).get("id")
    except DaemonError:
        return None
    return request_id if isinstance(request_id, (str, int)) else None


def result_line(request_id: RequestId, result: dict[str, Any]) -> bytes:
    return encode({"id": request_id, "result": result})


def error_line(request_id: RequestId, error: Exception) -> bytes:
    """An error with the parts of its refusal; an unforeseen exception is sent with its type and text."""
    if isinstance(error, LongreachError):
        parts: dict[str, Any] = {"class": type(error).__name__, **error.refusal.as_dict()}
    else:
        parts = {"class": "DaemonError", "what": "internal error of the daemon", "value": f"{type(error).__name__}: {error}"}
        parts["next_step"] = "Please report this with the daemon's journal."
    return encode({"id": request_id, "error": parts})


def error_from(parts: dict[str, Any]) -> LongreachError:
    """The exception an error answer stands for; classes this version does not know become DaemonError."""
    known = getattr(errors, str(parts.get("class")), DaemonError)
    kind = known if isinstance(known, type) and issubclass(known, LongreachError) else DaemonError
    keywords = {key: str(parts.get(key, "")) for key in ("value", "limit", "unit", "where", "next_step")}
    mend = parts.get("mend")
    return kind(str(parts.get("what", "refused")), **keywords, mend=mend if isinstance(mend, dict) else {})


def result_of(answer: dict[str, Any]) -> dict[str, Any]:
    """The result in an answer. Raises the refusal it holds (a LongreachError)."""
    if "error" in answer:
        raise error_from(answer["error"])
    result: dict[str, Any] = answer["result"]
    return result


def no_answer(where: str, error: OSError) -> DaemonError:
    """What to say when the connection to the socket at `where` cannot be made, or breaks."""
    advice = {
        FileNotFoundError: "Start it: `longreachd ornl_testbed`, or your rig file, or `systemctl start longreachd`; or give --socket.",
        ConnectionRefusedError: "A daemon that ended has left the socket. Start one: `longreachd ornl_testbed`, or your rig file.",
        PermissionError: f"`ls -ld {shlex.quote(where)}` names its group: ask to be added to it, then log in again.",
        TimeoutError: "See `systemctl status longreachd`.",
    }
    next_step = advice.get(type(error), "See the daemon's journal: `journalctl -u longreachd`.")
    return DaemonError("no answer from the daemon", value=error.strerror or str(error), where=where, next_step=next_step)


class Client:
    """A connection to the daemon. `call` sends one request and waits for its answer; use it from one thread at a time."""

    def __init__(self, path: str | PathLike[str], timeout_s: float = DEFAULT_TIMEOUT_S) -> None:
        """Connects at once. Raises DaemonError when nobody listens at `path`."""
        self._where = str(path)
        self._timeout_s = timeout_s
        self._next_id = 1
        self._received = b""
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(timeout_s)
        try:
            self._socket.connect(self._where)
        except OSError as error:
            self._socket.close()
            raise no_answer(self._where, error) from error

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """The daemon's result. Raises the daemon's refusal (a LongreachError), or DaemonError when the connection fails."""
        request_id = self._next_id
        self._next_id += 1
        longest_s = self._timeout_s + _LONGER_S.get(method, 0.0) + sum(float(params.get(wait) or 0.0) for wait in _WAITS)
        try:
            self._socket.settimeout(longest_s)
            self._socket.sendall(encode({"v": VERSION, "id": request_id, "method": method, "params": params}))
            answer = json_object(self._line())
        except OSError as error:
            self.close()  # an answer that comes late after all must not be taken for that of the next request
            raise no_answer(self._where, error) from error
        return result_of(answer)

    def _line(self) -> bytes:
        while b"\n" not in self._received:
            data = self._socket.recv(65536)
            if not data:
                raise ConnectionResetError("the daemon closed the connection")
            self._received += data
        line, _, self._received = self._received.partition(b"\n")
        return line

    def close(self) -> None:
        self._socket.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def json_object(line: bytes) -> dict[str, Any]:
    """The object in a line. Raises DaemonError for anything else."""
    try:
        message = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise DaemonError("a line is not JSON", value=str(error)[:200], next_step="Send one JSON object a line.") from error
    if not isinstance(message, dict):
        raise DaemonError("a line is not a JSON object", value=type(message).__name__, next_step="Send one JSON object a line.")
    return message


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {str(key): _finite(item) for key, item in value.items()}
    return [_finite(item) for item in value] if isinstance(value, (list, tuple)) else value
