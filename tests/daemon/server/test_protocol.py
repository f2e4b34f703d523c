from __future__ import annotations

import asyncio
import grp
import json
import os
import socket
import threading
from collections.abc import Iterator
from math import inf, nan
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config.errors import DaemonError, ManeuverError
from daemon.server.protocol import MAX_LINE_BYTES, Client, encode, error_from, error_line, no_answer, parse_request
from daemon.server.socket_server import answer, serve, serving

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=10,
)


async def echo(params: dict[str, Any]) -> dict[str, Any]:
    return {"params": params}


async def refuse(params: dict[str, Any]) -> dict[str, Any]:
    raise ManeuverError("too fast", value=3.0, limit=2.0, unit="m/s", where="line 1", next_step="Slow down.")


async def broken(params: dict[str, Any]) -> dict[str, Any]:
    raise ZeroDivisionError("oops")


async def late(params: dict[str, Any]) -> dict[str, Any]:
    await asyncio.sleep(0.2)
    return {"late": True}


METHODS = {"echo": echo, "refuse": refuse, "broken": broken, "late": late}


def answered(line: bytes) -> dict[str, Any]:
    reply: dict[str, Any] = json.loads(asyncio.run(answer(line, METHODS)))
    return reply


def test_a_request_is_answered_with_its_id() -> None:
    assert answered(b'{"v":1,"id":7,"method":"echo","params":{"a":1}}\n') == {"id": 7, "result": {"params": {"a": 1}}}


def test_a_refusal_keeps_all_its_parts_and_its_class_on_the_way() -> None:
    error = answered(b'{"v":1,"id":"x","method":"refuse"}\n')["error"]
    rebuilt = error_from(error)
    assert isinstance(rebuilt, ManeuverError)
    assert str(rebuilt) == "line 1: too fast: 3.0 m/s (limit: 2.0 m/s). Slow down."


def test_a_mistake_of_ours_is_told_and_not_fatal() -> None:
    error = answered(b'{"v":1,"id":1,"method":"broken"}\n')["error"]
    assert error["class"] == "DaemonError"
    assert "ZeroDivisionError" in error["value"]


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        (b"\n", "not JSON"),
        (b"[1]\n", "not a JSON object"),
        (b'{"v":2,"id":1,"method":"echo"}\n', "protocol version"),
        (b'{"v":1,"id":1}\n', "method"),
        (b'{"v":1,"id":1,"method":"fly"}\n', "unknown method"),
        (b'{"v":1,"id":1,"method":"echo","params":[]}\n', "params"),
        (b'{"v":1,"id":{},"method":"echo"}\n', "id"),
        (b"[" * 100_000 + b"\n", "not JSON"),
        (b"\xff\xfe\n", "not JSON"),
    ],
)
def test_malformed_lines_are_answered_with_what_is_wrong(line: bytes, complaint: str) -> None:
    assert complaint in answered(line)["error"]["what"]


@given(st.binary(max_size=300))
def test_any_bytes_are_answered(data: bytes) -> None:
    reply = answered(data)
    assert "error" in reply or "result" in reply


@pytest.mark.slow
@given(JSON, JSON, JSON, JSON)
def test_any_json_is_answered(version: object, request_id: object, method: object, params: object) -> None:
    for line in (
        {"v": version, "id": request_id, "method": method, "params": params},
        {"v": 1, "id": 1, "method": "echo", "params": params},
    ):
        reply = answered(json.dumps(line).encode())
        assert "error" in reply or "result" in reply


@given(JSON)
def test_what_is_encoded_is_one_line_of_strict_json(content: object) -> None:
    line = encode({"id": 1, "result": {"x": content}})
    assert line.count(b"\n") == 1
    json.loads(line, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))


def test_numbers_that_are_not_finite_travel_as_null() -> None:
    assert json.loads(encode({"a": nan, "b": [inf, (1.0, nan)]})) == {"a": None, "b": [None, [1.0, None]]}


def test_an_error_of_a_class_nobody_knows_is_a_daemon_error() -> None:
    for name in ("Whatever", "Refusal", "annotations", None):
        assert type(error_from({"class": name, "what": "x"})) is DaemonError
    assert parse_request(b'{"v":1,"method":"m"}').id is None
    assert json.loads(error_line(3, ValueError("v")))["id"] == 3


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Path]:
    """The socket server in a thread of its own."""
    path, ready, loop = tmp_path / "s", threading.Event(), asyncio.new_event_loop()

    async def listen() -> None:
        await serve(path, None, METHODS)
        ready.set()

    def run() -> None:
        loop.run_until_complete(listen())
        loop.run_forever()

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    assert ready.wait(10)
    yield path
    loop.call_soon_threadsafe(loop.stop)
    thread.join(10)


def test_client_and_server_over_a_real_socket(server: Path) -> None:
    with Client(server) as client:
        assert client.call("echo", text="längs\n", number=1.5) == {"params": {"text": "längs\n", "number": 1.5}}
        with pytest.raises(ManeuverError, match="too fast"):
            client.call("refuse")
        assert client.call("echo") == {"params": {}}, "a refusal does not end the connection"
    assert server.stat().st_mode & 0o777 == 0o600


def test_after_a_time_out_a_late_answer_is_not_taken_for_the_next_one(server: Path) -> None:
    with Client(server, timeout_s=0.05) as client:
        with pytest.raises(DaemonError, match="no answer from the daemon"):
            client.call("late")
        with pytest.raises(DaemonError, match="no answer from the daemon"):
            client.call("echo", text="mine")


@pytest.mark.parametrize(
    ("method", "params", "longest_s"),
    [("prove", {"countdown_s": 60.0}, 60.0 + 20.0), ("prove", {}, 30.0 + 20.0), ("reset", {}, 35.0), ("start", {"settle_s": 600.0}, 600.0)],
)
def test_the_client_waits_longer_than_the_daemon_may_take(
    server: Path, monkeypatch: pytest.MonkeyPatch, method: str, params: dict[str, float], longest_s: float
) -> None:
    """`prove`: countdown (the rig's, at most 30 s, if none is given), and 20 s; `reset`: recorder and devices anew."""
    waits: list[float] = []
    with Client(server) as client:
        monkeypatch.setattr(client, "_socket", Recording(client._socket, waits))
        with pytest.raises(DaemonError):
            client.call(method, **params)
    assert waits[-1] > longest_s


class Recording:
    """A socket that keeps the time-outs it is given."""

    def __init__(self, real: socket.socket, waits: list[float]) -> None:
        self._real, self._waits = real, waits

    def settimeout(self, seconds: float) -> None:
        self._waits.append(seconds)
        self._real.settimeout(seconds)

    def __getattr__(self, name: str) -> object:
        return getattr(self._real, name)


def test_a_line_without_end_is_refused_and_others_are_still_served(server: Path) -> None:
    with socket.socket(socket.AF_UNIX) as flood:
        flood.settimeout(10)
        flood.connect(str(server))
        try:
            for _ in range(MAX_LINE_BYTES // 65536 + 3):
                flood.sendall(b"x" * 65536)
            reply = flood.recv(65536)
        except ConnectionError:
            reply = b"too long"  # closed while we were still sending
        assert b"too long" in reply
    with Client(server) as client:
        assert client.call("echo") == {"params": {}}


@settings(max_examples=20, deadline=None)
@given(lines=st.lists(st.binary(max_size=200), max_size=5))
def test_garbage_over_the_socket_never_stops_the_server(lines: list[bytes]) -> None:
    async def scenario(directory: Path) -> bytes:
        running = await serve(directory / "s", None, METHODS)
        reader, writer = await asyncio.open_unix_connection(directory / "s")
        for line in lines:
            writer.write(line + b"\n")
        writer.write(b'{"v":1,"id":"last","method":"echo"}\n')
        replies = b""
        while b'"last"' not in replies:
            replies += await asyncio.wait_for(reader.readline(), 10)
        writer.close()
        running.close()
        return replies

    import tempfile

    with tempfile.TemporaryDirectory() as directory:
        assert b'"params": {}'.replace(b" ", b"") in asyncio.run(scenario(Path(directory)))


def test_no_daemon_says_how_to_start_one(tmp_path: Path) -> None:
    with pytest.raises(DaemonError, match="longreachd"):
        Client(tmp_path / "nobody")
    stale = socket.socket(socket.AF_UNIX)
    stale.bind(str(tmp_path / "stale"))
    stale.close()
    with pytest.raises(DaemonError, match="has left the socket"):
        Client(tmp_path / "stale")


async def started(path: Path) -> None:
    async with serving(path, None, METHODS):
        pass


def test_the_socket_of_a_living_daemon_stays_its_own(server: Path) -> None:
    """An e-stop for one rig must not reach another one."""
    with pytest.raises(DaemonError, match="another daemon has this socket"):
        asyncio.run(started(server))
    with Client(server) as client:
        assert client.call("echo") == {"params": {}}


def test_what_a_killed_daemon_left_is_replaced_and_removed_at_the_end(tmp_path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as leftover:
        leftover.bind(str(tmp_path / "s"))
    assert (tmp_path / "s").exists()
    asyncio.run(started(tmp_path / "s"))
    assert not (tmp_path / "s").exists()


def test_a_file_in_the_sockets_place_stays(tmp_path: Path) -> None:
    rig = tmp_path / "my_rig.yaml"
    rig.write_text("name: my_rig\n")
    with pytest.raises(DaemonError, match=r"my_rig.yaml: the socket's place is taken by a file"):
        asyncio.run(started(rig))
    assert rig.read_text() == "name: my_rig\n"


def test_a_socket_that_somebody_else_has_put_there_is_not_removed(tmp_path: Path) -> None:
    async def replaced() -> None:
        async with serving(tmp_path / "s", None, METHODS):
            (tmp_path / "s").unlink()
            (tmp_path / "s").write_text("another one's")

    asyncio.run(replaced())
    assert (tmp_path / "s").read_text() == "another one's"


def test_the_socket_is_for_the_user_and_the_group(tmp_path: Path) -> None:
    asyncio.run(serve(tmp_path / "s", grp.getgrgid(os.getgid()).gr_name, METHODS))
    assert (tmp_path / "s").stat().st_mode & 0o777 == 0o660
    assert (tmp_path / "s").stat().st_gid == os.getgid()


def test_a_group_nobody_has_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DaemonError, match="no-such-group"):
        asyncio.run(serve(tmp_path / "s", "no-such-group", METHODS))


@pytest.mark.parametrize(
    ("error", "command"),
    [
        (FileNotFoundError(2, "No such file or directory"), "longreachd ornl_testbed"),
        (ConnectionRefusedError(111, "Connection refused"), "longreachd ornl_testbed"),
        (PermissionError(13, "Permission denied"), "ls -ld '/run/a b/longreach.sock'"),
        (TimeoutError(110, "timed out"), "systemctl status longreachd"),
        (ConnectionResetError(104, "reset"), "journalctl -u longreachd"),
    ],
    ids=lambda given: type(given).__name__ if isinstance(given, OSError) else "",
)
def test_where_nobody_answers_the_next_command_is_not_one_that_asks_again(error: OSError, command: str) -> None:
    assert no_answer("/run/a b/longreach.sock", error).refusal.named_command() == command
