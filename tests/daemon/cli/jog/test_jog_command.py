"""`longreach jog` in a terminal emulator beside a real daemon: keys move the arm, silence stops it, and what ends it is said."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest

from daemon.server.protocol import Client
from recording.evaluation.replay import reexecute
from tests.support.daemon.running_daemon import RunningDaemon, until
from tests.support.live.gentle_daemon import gentle_daemon, holding
from tests.support.live.terminal import Terminal, longreach_in_terminal

pytestmark = pytest.mark.clock

LEFT, UP = b"\x1b[D", b"\x1b[A"
REPEAT_S = 0.03


@pytest.fixture(scope="module")
def daemon(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDaemon]:
    with gentle_daemon(tmp_path_factory.mktemp("daemon")) as running:
        yield running


@pytest.fixture
def client(daemon: RunningDaemon) -> Iterator[Client]:
    with holding(daemon) as client:
        yield client


@pytest.fixture
def terminal(daemon: RunningDaemon, client: Client) -> Iterator[Terminal]:
    """A jog that may move."""
    with longreach_in_terminal("--socket", str(daemon.socket), "jog", "--countdown", "0.2", "--speed", "20") as terminal:
        until(lambda: client.call("status")["mode"] == "running", 60.0)
        terminal.shows(lambda text: "standing still" in text)
        yield terminal


def joint(client: Client, name: str) -> float:
    return float(client.call("status")["joints"][name]["target"])


def hold(terminal: Terminal, client: Client, key: bytes, name: str, way: float) -> None:
    """As a keyboard repeats a key, until the joint has gone so far."""
    before = joint(client, name)

    def moved() -> bool:
        terminal.press(key)
        time.sleep(REPEAT_S)  # between two repeats
        return abs(joint(client, name) - before) > way

    until(moved, 60.0)


def rests(client: Client) -> bool:
    before = joint(client, "rotary")
    time.sleep(0.05)  # of motion, if there is any
    return joint(client, "rotary") == before


def test_held_keys_move_both_joints_silence_stops_them_and_q_ends(terminal: Terminal, client: Client, daemon: RunningDaemon) -> None:
    hold(terminal, client, LEFT, "rotary", 0.05)
    until(lambda: rests(client))
    assert joint(client, "rotary") > 0.05
    hold(terminal, client, UP, "prismatic", 0.01)
    until(lambda: rests(client))
    assert client.call("status")["mode"] == "running"
    assert re.search(r"rotary +\d\.\d+ deg", terminal.shows(lambda text: "standing still" in text))
    terminal.press(b"q")
    assert re.search(r"run \d+: valid", terminal.shows(lambda text: "valid" in text))
    assert terminal.process.wait(30) == 0
    assert terminal.settings() == terminal.settings_before
    log = client.call("status")["log"]["path"]
    client.call("disarm")
    until(lambda: "closing" in _metadata(log))
    assert reexecute(log).identical


def _metadata(path: str) -> set[str]:
    from recording.files.reader import read_log

    return set(read_log(path).metadata)


def test_speed_and_tip_are_shown(terminal: Terminal) -> None:
    terminal.press(b"+")
    terminal.shows(lambda text: "50 % of the limits: rotary 27.7" in text)
    terminal.press(b"--")
    terminal.shows(lambda text: "10 % of the limits" in text)
    terminal.press(b"t")
    terminal.shows(lambda text: re.search(r"tip 0\.16\d* m/s", text))


def test_q_in_the_countdown_ends_a_valid_run(daemon: RunningDaemon, client: Client) -> None:
    with longreach_in_terminal("--socket", str(daemon.socket), "jog", "--countdown", "1") as terminal:
        terminal.shows(lambda text: "MOTION CAN START" in text)
        terminal.press(b"q")
        terminal.shows(lambda text: ": valid" in text)
        assert terminal.process.wait(30) == 0


def test_e_is_the_e_stop(terminal: Terminal, client: Client) -> None:
    hold(terminal, client, LEFT, "rotary", 0.03)
    terminal.press(b"e")
    until(lambda: client.call("status")["mode"] == "fault")
    terminal.shows(lambda text: "e-stop was asked for" in text)
    assert terminal.process.wait(30) == 1
    client.call("reset")


def test_the_e_stop_key_counts_before_whatever_comes_with_it_and_as_a_capital(terminal: Terminal, client: Client) -> None:
    terminal.press(b"qE")
    until(lambda: client.call("status")["mode"] == "fault")
    assert terminal.process.wait(30) == 1
    client.call("reset")


def test_a_jog_that_is_killed_leaves_an_arm_that_holds(terminal: Terminal, client: Client) -> None:
    hold(terminal, client, LEFT, "rotary", 0.03)
    terminal.process.kill()
    until(lambda: client.call("status")["mode"] == "holding")
    run = client.call("status")["run"]
    assert run["validity"] == "invalid"
    assert any(check in run["reason"] for check in ("driving client", "set points arriving"))


def test_a_stop_by_somebody_else_ends_it_with_the_reason(terminal: Terminal, client: Client) -> None:
    client.call("stop")
    terminal.shows(lambda text: "stop was asked for" in text)
    assert terminal.process.wait(30) == 1


def test_without_a_terminal_it_says_what_programs_use(client: Client, daemon: RunningDaemon) -> None:
    command = [sys.executable, "-m", "daemon.cli.main", "--socket", str(daemon.socket), "jog"]
    answer = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    assert answer.returncode == 1
    assert "driving by keys needs a terminal" in answer.stderr
    assert "longreach.drive" in answer.stderr
    assert client.call("status")["mode"] == "holding"
