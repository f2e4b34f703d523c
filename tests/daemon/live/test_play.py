"""A log that is played: what its socket answers against the log's own columns, and into each view."""

from __future__ import annotations

import asyncio
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from config.errors import DaemonError, UsageError
from daemon.checks.past_checks import checks_at
from daemon.live.playback.log_methods import ROW_S, LogMethods
from daemon.live.playback.log_player import LogPlayer
from daemon.lockstep import LockstepRig
from daemon.server.protocol import Client
from recording.files.reader import Log, read_log
from servo_control.signals import Mode
from tests.support.daemon.rigs import JOG, RIG
from tests.support.live.terminal import longreach_in_terminal


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of one jog on the simulated rig."""
    with LockstepRig(RIG, tmp_path_factory.mktemp("log")) as rig:
        rig.arm()
        rig.start(JOG)
        rig.until(lambda: rig.mode is Mode.RUNNING, 10.0)
        rig.until(lambda: rig.mode is Mode.HOLDING, 10.0)
        rig.cycles(200)
        rig.disarm()
        return rig.recorder.finished[-1]


@pytest.fixture(scope="module")
def log(path: Path) -> Log:
    return read_log(path)


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def asked(methods: LogMethods, method: str, **params: Any) -> dict[str, Any]:
    async def ask() -> dict[str, Any]:
        return await methods.methods[method](params)

    return asyncio.run(ask())


@pytest.mark.parametrize("speed", [0.5, 1.0, 7.0])
def test_the_rows_are_those_of_the_log_at_the_speed(log: Log, speed: float) -> None:
    clock = Clock()
    methods = LogMethods(LogPlayer(log, speed, 0.1, clock))
    names = [name for name, _ in asked(methods, "rig")["signals"]]
    t, seen, since = names.index("t_s"), [], -1e9
    asked(methods, "status")  # from now on it plays
    for _ in range(20):
        clock.now += 0.05
        rows = asked(methods, "sample", since_t_s=since)["rows"]
        assert rows
        seen += rows
        since = rows[-1][t]
        due_s = log.columns["t_s"][0] + 0.1 + speed * (clock.now - 100.0)
        assert since == pytest.approx(min(due_s, log.columns["t_s"][-1]), abs=1.5e-3)
        if since == log.columns["t_s"][-1]:
            break
    times = [row[t] for row in seen]
    assert times == sorted(set(times))
    if speed > 1.0:
        assert max(np.diff(times)) <= ROW_S + 1.5e-3
    for row in seen:
        at = int(np.flatnonzero(log.columns["t_s"] == row[t])[0])
        for name in ("rotary.position", "prismatic.command_V", "tip.acceleration_mps2", "mode", "late_us"):
            assert row[names.index(name)] == pytest.approx(float(log.columns[name][at]), nan_ok=True), name


def test_at_its_end_it_stays_and_sends_nothing_twice(log: Log) -> None:
    clock = Clock()
    methods = LogMethods(LogPlayer(log, 1000.0, 0.0, clock))
    asked(methods, "status")
    clock.now += 60.0
    rows = asked(methods, "sample")["rows"]
    assert len(rows) > 50
    names = [name for name, _ in asked(methods, "rig")["signals"]]
    assert asked(methods, "sample", since_t_s=rows[-1][names.index("t_s")])["rows"] == []
    status = asked(methods, "status")
    assert status["mode"] == Mode(int(log.columns["mode"][-1])).name.lower()
    assert status["run"]["maneuver"] == "jog"
    assert status["run"]["validity"] == "valid"
    assert status["clock"] == "log"


def test_in_the_middle_of_a_run_status_events_and_checks_are_those_of_the_moment(log: Log) -> None:
    rows = np.flatnonzero(log.columns["mode"] == Mode.RUNNING)
    middle = float(log.columns["t_s"][rows[len(rows) // 2]])
    methods = LogMethods(LogPlayer(log, 1.0, middle - float(log.columns["t_s"][0]), Clock()))
    status = asked(methods, "status")
    assert (status["mode"], status["run"]["validity"]) == ("running", "running")
    assert status["run"]["elapsed_s"] == pytest.approx(middle - log.columns["t_s"][rows[0]], abs=2e-3)
    texts = [event["text"] for event in asked(methods, "events")["events"]]
    assert texts == [event.text for event in log.events if event.t_s <= middle]
    shown = {check["name"]: (check["ok"], check["value"]) for check in asked(methods, "checks")["checks"]}
    expected = checks_at(log, status["t_s"]).checks
    assert shown == {check["name"]: (check["ok"], pytest.approx(check["value"], nan_ok=True)) for check in expected}
    assert shown["e-stop"] == (None, None)


def test_nothing_can_be_driven(log: Log) -> None:
    methods = LogMethods(LogPlayer(log))
    for method in ("arm", "disarm", "reset", "start", "stop", "estop", "prove", "wait", "shutdown"):
        with pytest.raises(DaemonError, match="looked at, not driven"):
            asked(methods, method)


@pytest.mark.parametrize(("speed", "from_s"), [(0.0, 0.0), (-1.0, 0.0), (float("nan"), 0.0), (1e6, 0.0), (1.0, -1.0), (1.0, 1e6)])
def test_speeds_and_moments_that_cannot_be_are_refused(log: Log, speed: float, from_s: float) -> None:
    with pytest.raises(UsageError, match="--speed" if from_s == 0.0 else "--from"):
        LogPlayer(log, speed, from_s)


@pytest.mark.slow
def test_into_the_terminal(path: Path) -> None:
    with longreach_in_terminal("play", str(path), "top", "--speed", "0.2") as terminal:
        terminal.shows(lambda text: "HOLDING" in text or "RUNNING" in text)
        terminal.shows(lambda text: "run 1: jog" in text and "valid" in text and "DISARMED" in text)
        terminal.press(b"q")
        assert terminal.process.wait(20) == 0


@pytest.mark.slow
def test_into_any_command_by_a_socket_of_its_own(path: Path, tmp_path: Path) -> None:
    socket = tmp_path / "played.sock"
    command = [sys.executable, "-m", "daemon.cli.main", "play", str(path), "--at", str(socket), "--speed", "1000"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        assert str(socket) in process.stdout.readline()
        with Client(socket) as client:
            assert client.call("rig")["played"] == path.name
        shown = subprocess.run(
            [sys.executable, "-m", "daemon.cli.main", "--socket", str(socket), "status"], capture_output=True, text=True, timeout=60
        )
        assert "ornl_testbed" in shown.stdout
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0
        assert not socket.exists()
    finally:
        process.kill()
        process.wait(10)
