"""`longreach live` with the protocol client and ROS 2 decoder of Foxglove: JavaScript, `npm ci` in tests/support/live/foxglove_client."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from config.units import to_si
from daemon.server.protocol import Client
from tests.support.live.lockstep_daemon import lockstep_daemon

CLIENT = Path(__file__).parents[2] / "support" / "live" / "foxglove_client"
LIMIT_LINES = 20000

Said = dict[str, Any]


@pytest.fixture
def socket(tmp_path: Path) -> Iterator[Path]:
    if shutil.which("node") is None or not (CLIENT / "node_modules").is_dir():
        pytest.skip(f"Foxglove's client is not installed (npm ci --prefix {CLIENT})")
    with lockstep_daemon(tmp_path) as path:
        yield path


@contextmanager
def live(socket: Path, *words: str) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """Address and process of `longreach live`."""
    command = [sys.executable, "-m", "daemon.cli.main", "--socket", str(socket), "live", "--port", "0", *words]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        yield process.stdout.readline().strip(), process
    finally:
        process.kill()
        process.wait(10)


@contextmanager
def client(address: str) -> Iterator[Callable[[Callable[[Said], object]], Said]]:
    """What the client says, line by line: the next one that meets a condition."""
    process = subprocess.Popen(["timeout", "60", "node", str(CLIENT / "client.cjs"), address], stdout=subprocess.PIPE, text=True)

    def next_that(condition: Callable[[Said], object]) -> Said:
        assert process.stdout is not None
        for _ in range(LIMIT_LINES):
            said: Said = json.loads(process.stdout.readline())
            assert "error" not in said
            if condition(said):
                return said
        raise AssertionError("not among the messages")

    try:
        yield next_that
    finally:
        process.kill()
        process.wait(10)


def test_foxglove_s_client_decodes_the_topics_of_the_log(socket: Path) -> None:
    with live(socket) as (address, _), client(address) as next_that:
        info = next_that(lambda said: "name" in said)
        assert info["name"] == "longreach"
        assert info["capabilities"] == []
        topics = {next_that(lambda said: "advertised" in said)["advertised"] for _ in range(2)}
        assert topics == {"/cycle", "/event"}
        first = next_that(lambda said: said.get("topic") == "/cycle")["message"]
        assert first["prismatic"]["position"] == pytest.approx(to_si("40 in", "m"), abs=1e-3)
        assert first["rotary"]["supply_pressure_pa"] == pytest.approx(to_si("2000 psi", "Pa"), rel=0.05)
        assert first["mode"] == 0
        assert first["rotary"]["position_raw"] is None  # live data carry no counts
        later = next_that(lambda said: said.get("topic") == "/cycle" and said["message"]["cycle"] > first["cycle"])["message"]
        assert later["t_s"] > first["t_s"]
        with Client(socket) as daemon:
            daemon.call("reset")
            daemon.call("estop")
        event = next_that(lambda said: said.get("topic") == "/event" and said["message"]["name"] == "fault")["message"]
        assert event["text"] == "e-stop was asked for"
        assert event["level"] == 50


def test_the_layout_shows_what_is_sent(socket: Path, tmp_path: Path) -> None:
    """Every path of the layout is a field of a message."""
    written = tmp_path / "layout.json"
    with live(socket, "--layout", str(written)) as (address, _), client(address) as next_that:
        cycle = next_that(lambda said: said.get("topic") == "/cycle")["message"]
        layout = json.loads(written.read_text())
    paths = [path["value"] for panel in layout["configById"].values() for path in panel.get("paths", [])]
    assert len(paths) > 10
    for path in paths:
        topic, _, fields = path.partition(".")
        assert topic == "/cycle"
        value: Any = cycle
        for name in fields.split("."):
            assert name in value, path
            value = value[name]


def test_it_ends_in_order(socket: Path) -> None:
    with live(socket) as (_, process):
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == 0


def test_a_port_that_is_taken_is_said(socket: Path) -> None:
    with live(socket) as (address, _):
        command = [sys.executable, "-m", "daemon.cli.main", "--socket", str(socket), "live", "--port", address.rpartition(":")[2]]
        second = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert second.returncode == 1
    assert "the port cannot be had" in second.stderr
    assert second.stderr.splitlines()[-1].endswith("live --port 0")
    assert "--port" in second.stderr


def test_a_daemon_that_does_not_answer_is_told_once(tmp_path: Path) -> None:
    with live(tmp_path / "none") as (first, process), lockstep_daemon(tmp_path) as path:
        assert "no answer from the daemon" in first
        path.rename(tmp_path / "none")
        assert process.stdout is not None
        assert process.stdout.readline().startswith("ws://127.0.0.1:")
