"""The page's two web sockets, live data and driving: who may open them, and what passes through."""

from __future__ import annotations

import json
from contextlib import ExitStack
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from daemon.live.page.application import MOST_VIEWS
from daemon.server.protocol import Client
from tests.support.daemon.running_daemon import RunningDaemon, until
from tests.support.live.page_server import TOKEN, PageServer

pytestmark = pytest.mark.clock


def mode(daemon: RunningDaemon) -> str:
    with Client(daemon.socket) as client:
        return str(client.call("status")["mode"])


def test_live_data_only_with_the_token_and_from_the_page(looking: PageServer) -> None:
    address = f"ws://127.0.0.1:{looking.port}/live"
    with connect(address) as window:
        window.send(TOKEN)
        seen: dict[str, object] = {}
        while not {"rig", "samples", "status", "checks"} <= seen.keys():
            seen |= json.loads(window.recv(timeout=20))
        assert seen["control"] is False
    with connect(address) as window:
        window.send("wrong")
        with pytest.raises(Exception, match="4401"):
            window.recv(timeout=20)
    with pytest.raises(Exception, match="403"), connect(address, additional_headers={"Origin": "http://evil.example"}):
        pass


def test_one_window_too_many_is_told_that_and_not_that_its_token_is_wrong(looking: PageServer) -> None:
    with ExitStack() as windows:
        for _ in range(MOST_VIEWS):
            window = windows.enter_context(connect(f"ws://127.0.0.1:{looking.port}/live"))
            window.send(TOKEN)
            window.recv(timeout=20)
        last = windows.enter_context(connect(f"ws://127.0.0.1:{looking.port}/live"))
        last.send(TOKEN)
        with pytest.raises(ConnectionClosed) as closed:
            last.recv(timeout=20)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 4429


def drive_address(page: PageServer) -> str:
    return f"ws://127.0.0.1:{page.port}/drive"


def sent_and_answered(window: ClientConnection, token: str) -> None:
    window.send(token)
    window.recv(20)


def test_driving_needs_control_the_token_and_the_page_s_own_place(looking: PageServer, driving: PageServer, daemon: RunningDaemon) -> None:
    for page, token in ((looking, TOKEN), (driving, "another"), (driving, "")):
        with connect(drive_address(page)) as window:
            with pytest.raises(ConnectionClosed) as closed:
                sent_and_answered(window, token)
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 4401
    with pytest.raises(Exception, match="403"), connect(drive_address(driving), additional_headers={"Origin": "http://evil.example"}):
        pass
    assert mode(daemon) == "disarmed"


def test_a_window_drives_what_it_asked_for_alone_and_the_arm_stops_when_it_closes(driving: PageServer, daemon: RunningDaemon) -> None:
    def asked(window: ClientConnection, content: object) -> dict[str, Any]:
        window.send(content if isinstance(content, str) else json.dumps(content))
        answer: dict[str, Any] = json.loads(window.recv(30))
        return answer

    with Client(daemon.socket) as client:
        client.call("reset")
        client.call("arm")
        with connect(drive_address(driving)) as window:
            window.send(TOKEN)
            for wrong in (
                "{",
                "[]",
                {"method": "estop"},
                {"method": "stream", "params": 5},
                {"method": "set_point", "params": {"timeout_s": 1}},
            ):
                assert "error" in asked(window, wrong)
            assert (
                asked(window, {"method": "set_point", "params": {"run": 1, "rate": {}}})["error"]["what"] == "no such run is driven by hand"
            )
            run = asked(window, {"method": "stream", "params": {"countdown_s": 0.0}})["result"]["run"]
            until(lambda: client.call("status")["mode"] == "running")
            point = {"method": "set_point", "params": {"run": run, "rate": {"rotary": 0.1}}}
            until(lambda: asked(window, point) and abs(client.call("status")["joints"]["rotary"]["target"]) > 0.02)
        result = client.call("wait", run=run, timeout_s=10.0)
        assert result["validity"] == "invalid"
        assert "driving client" in result["reason"]
        until(lambda: mode(daemon) == "holding")
        client.call("disarm")
