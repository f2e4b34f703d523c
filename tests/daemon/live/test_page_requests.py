"""What the page's server refuses and what it passes on, over real HTTP beside a real daemon."""

from __future__ import annotations

import asyncio
import base64
import json
import os
import socket
import threading
from pathlib import Path

import pytest

from daemon.server.client_connection import client_has_left
from daemon.server.protocol import Client
from daemon.server.socket_server import serve
from recording.files.reader import read_log
from tests.support.daemon.running_daemon import RunningDaemon, until
from tests.support.live.page_server import TOKEN, PageServer, page_server

pytestmark = pytest.mark.clock


def mode(daemon: RunningDaemon) -> str:
    with Client(daemon.socket) as client:
        return str(client.call("status")["mode"])


def test_without_the_token_everything_but_the_page_itself_is_refused(driving: PageServer, daemon: RunningDaemon) -> None:
    for headers in (
        {"Authorization": ""},
        {"Authorization": "Bearer "},
        {"Authorization": f"Basic {TOKEN}"},
        {"Authorization": "Bearer x"},
    ):
        assert driving.ask("estop", headers)[0] == 401
        assert driving.send("GET", "/api/maneuvers", headers=headers)[0] == 401
        assert driving.send("POST", "/api/plan", b"{}", headers)[0] == 401
    assert driving.send("GET", "/", headers={"Authorization": ""})[0] == 200
    assert mode(daemon) == "disarmed"


def test_another_origin_and_another_name_are_refused_even_with_the_token(driving: PageServer, daemon: RunningDaemon) -> None:
    for headers in (
        {"Origin": "http://evil.example"},
        {"Origin": f"https://127.0.0.1:{driving.port}"},
        {"Origin": f"http://127.0.0.1:{driving.port + 1}"},
        {"Origin": "null"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
        {"Host": "evil.example"},
    ):
        assert driving.ask("estop", headers)[0] == 403, headers
    assert mode(daemon) == "disarmed"
    assert driving.ask("status", {"Origin": f"http://127.0.0.1:{driving.port}", "Sec-Fetch-Site": "same-origin"})[0] == 200


@pytest.mark.parametrize(
    ("status", "body", "headers"),
    [
        (415, b'{"method": "estop"}', {"Content-Type": "text/plain"}),
        (415, b"method=estop", {"Content-Type": "application/x-www-form-urlencoded"}),
        (400, b"", {}),
        (400, b"{", {}),
        (400, b"[1]", {}),
        (400, b"\xff\xfe", {}),
        (400, b"[" * 60000, {}),
        (400, b'{"method": "estop", "more": 1}', {}),
        (400, b'{"method": 7}', {}),
        (400, b'{"method": "estop", "params": []}', {}),
        (400, b'{"method": "shutdown"}', {}),
        (400, b'{"method": "__class__"}', {}),
        (413, b'{"method": "' + b"e" * 70000 + b'"}', {}),
    ],
)
def test_bad_content_is_refused(driving: PageServer, daemon: RunningDaemon, status: int, body: bytes, headers: dict[str, str]) -> None:
    answered, content, _ = driving.send("POST", "/api/request", body, headers)
    assert answered == status
    assert content["error"]["what"]
    assert mode(daemon) == "disarmed"


def test_a_page_without_control_looks_and_does_not_touch(looking: PageServer, daemon: RunningDaemon) -> None:
    assert looking.ask("status")[1]["mode"] == "disarmed"
    for method in ("arm", "disarm", "reset", "start", "stop", "estop", "prove"):
        status, content = looking.ask(method)
        assert status == 403
        assert f"longreach {method}" in content["error"]["next_step"]
    assert mode(daemon) == "disarmed"


def test_parameters_of_any_name_reach_the_daemon(looking: PageServer) -> None:
    """They are the client's: none may meet an argument of ours."""
    for name in ("timeout_s", "method", "self", "params", "path", "v"):
        body = json.dumps({"method": "status", "params": {name: 1}}).encode()
        status, content, _ = looking.send("POST", "/api/request", body)
        assert (status, content["mode"]) == (200, "disarmed")
    assert looking.ask("wait", timeout_s=0.1, run=99)[1]["error"]["what"] == "no such run"


def test_refusals_of_the_daemon_come_as_they_are(driving: PageServer, daemon: RunningDaemon) -> None:
    status, content = driving.ask("start", maneuver={"name": "jog"})
    assert status == 200
    assert content["error"] == {
        "class": "DaemonError",
        "what": "start refused",
        "value": "disarmed",
        "limit": "holding with no run under way",
        "next_step": "Run `longreach arm` first.",
    }


def test_every_answer_forbids_foreign_scripts_and_frames(looking: PageServer) -> None:
    for path in ("/", "/static/app.js", "/static/none.js", "/api/maneuvers", "/report/none"):
        headers = looking.send("GET", path)[2]
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "script-src 'self';" in policy
        assert "unsafe" not in policy
        assert "frame-ancestors 'none'" in policy
        assert headers["x-content-type-options"] == "nosniff"
    assert looking.send("GET", "/static/../../../../pyproject.toml")[0] == 404
    assert looking.send("GET", "/static/%2e%2e/server.py")[0] == 404


def test_it_listens_on_loopback_alone(looking: PageServer) -> None:
    addresses = {line.split()[1] for line in Path(f"/proc/{looking.pid}/net/tcp").read_text().splitlines()[1:] if line.split()[3] == "0A"}
    ours = {address.partition(":")[0] for address in addresses if int(address.partition(":")[2], 16) == looking.port}
    assert ours == {"0100007F"}


def test_a_plan_tells_path_and_vibration_and_moves_nothing(looking: PageServer, daemon: RunningDaemon) -> None:
    """The straight line of the paper: 60 in long at 40 in; a ZVD filter must leave less than none."""
    left = {}
    for shaper in ("none", "zvd"):
        wanted = {"maneuver": {"name": "paper_line"}, "approach": True, "shaper": {"kind": shaper}}
        status, plan, _ = looking.send("POST", "/api/plan", json.dumps(wanted).encode())
        assert status == 200, plan
        left[shaper] = max(move["nominal_mps2"] for move in plan["vibration"])
    xs, ys = zip(*plan["path"], strict=True)
    assert max(xs) - min(xs) == pytest.approx(60 * 0.0254, abs=1e-3)
    assert ys[-1] == pytest.approx(40 * 0.0254, abs=1e-6)
    assert left["zvd"] < 0.2 * left["none"]
    assert mode(daemon) == "disarmed"
    status, refused, _ = looking.send("POST", "/api/plan", json.dumps({"maneuver": {"name": "jog"}, "parameters": ["by=170 deg"]}).encode())
    assert status == 200
    assert refused["error"]["class"] == "ManeuverError"


def test_runs_are_listed_with_validity_and_each_opens_its_report(looking: PageServer, daemon: RunningDaemon) -> None:
    with Client(daemon.socket) as client:
        client.call("reset")
        client.call("arm")
        run = client.call("start", maneuver={"name": "jog"}, countdown_s=0.0)["run"]
        result = client.call("wait", run=run, timeout_s=30)
        log = Path(client.call("status")["log"]["path"])
        client.call("disarm")
    until(lambda: read_log(log).complete, 20.0)
    status, content, _ = looking.send("GET", "/api/runs")
    assert status == 200
    listed = next(each for each in content["runs"] if (each["log"], each["run"]) == (log.name, run))
    assert (listed["maneuver"], listed["valid"], listed["reason"]) == ("jog", result["validity"] == "valid", result["reason"])
    assert listed["vibration_mps2"] is None  # a jog has no hold to judge
    status, made, _ = looking.send("POST", "/api/report", json.dumps({"log": log.name, "run": run}).encode())
    assert status == 200
    status, page, headers = looking.send("GET", made["page"], headers={"Authorization": ""})
    assert status == 200
    assert f"run {run} of {log.name}".encode() in page
    assert "sandbox" in headers["content-security-policy"]
    assert "script-src" not in headers["content-security-policy"]


@pytest.mark.parametrize(
    "wanted",
    [
        {"log": "../../etc/passwd", "run": 1},
        {"log": "/etc/passwd", "run": 1},
        {"log": "a.txt", "run": 1},
        {"log": "a.mcap", "run": "1"},
        {"log": 7},
        {},
    ],
)
def test_reports_are_of_logs_in_the_daemon_s_folder_alone(looking: PageServer, daemon: RunningDaemon, wanted: dict[str, object]) -> None:
    """After the run above, so that there is a folder."""
    status, content, _ = looking.send("POST", "/api/report", json.dumps(wanted).encode())
    assert status == 400, content
    assert looking.send("GET", "/report/guessed")[0] == 404
    assert looking.send("GET", "/report/")[0] == 404
    status, content, _ = looking.send("POST", "/api/report", b'{"log": "none.mcap", "run": 1}')
    assert content["error"]["class"] == "LogError"


def test_a_browser_that_leaves_while_a_start_waits_hangs_up_on_the_daemon(tmp_path: Path) -> None:
    """The daemon then gives the start up (`client_has_left`): nobody would be there to stop it."""
    listening, begun, left = threading.Event(), threading.Event(), threading.Event()

    async def start(params: dict[str, object]) -> dict[str, object]:
        begun.set()
        while not client_has_left():
            await asyncio.sleep(0.01)
        left.set()
        return {}

    async def serve_start() -> None:
        server = await serve(tmp_path / "s", None, {"start": start})
        listening.set()
        await asyncio.to_thread(left.wait, 60.0)
        server.close()

    serving = threading.Thread(target=asyncio.run, args=(serve_start(),))
    serving.start()
    try:
        assert listening.wait(20.0)
        with page_server(tmp_path / "s", tmp_path, "--control") as page:
            head = f"POST /api/request HTTP/1.1\r\nHost: 127.0.0.1:{page.port}\r\nAuthorization: Bearer {TOKEN}\r\n"
            content = b'{"method": "start", "params": {"settle_s": 30}}'
            with socket.create_connection(("127.0.0.1", page.port)) as browser:
                browser.sendall(f"{head}Content-Type: application/json\r\nContent-Length: {len(content)}\r\n\r\n".encode() + content)
                assert begun.wait(20.0)
                assert not left.is_set()
            assert left.wait(20.0)
    finally:
        left.set()
        serving.join(20.0)


def test_garbage_on_the_port_ends_nothing(looking: PageServer) -> None:
    for junk in (
        b"\x00" * 4096,
        os.urandom(4096),
        b"GET / HTTP/9.9\r\n\r\n",
        b"POST /live HTTP/1.1\r\nHost: x\r\n\r\n",
        base64.b64encode(os.urandom(99)),
    ):
        with socket.create_connection(("127.0.0.1", looking.port)) as raw:
            raw.sendall(junk)
    assert looking.ask("status")[0] == 200
