"""The demo ends with its table whatever the machine does to its runs, and is strict with a rig that has hardware."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any, cast

import pytest

from config.errors import DaemonError, ManeuverError
from config.loading.load import load_rig
from daemon.cli.demo import demo_runs, demo_session
from daemon.cli.demo.demo_runs import DemoRuns
from daemon.cli.main import main
from daemon.cli.operate import measured_rate, private_daemon
from daemon.host.rate_seen import RateSeen
from daemon.server.protocol import Client
from recording.files.reader import read_log

LATE = RateSeen(1000.0, True, 2000, 5e-6, 30e-6, 60e-6, 150e-6, 0.002, 40, 21, 0, (), 1.0, 20, 0.05)
REQUESTS = {"jog": {"maneuver": {"name": "jog"}}, "again": {"maneuver": {"name": "jog"}}}


class Said:
    """A screen that remembers."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def say(self, line: str) -> None:
        self.lines.append(line)

    def status(self, status: dict[str, Any]) -> None: ...

    def share(self, elapsed_s: float, duration_s: float) -> None: ...


def overrun(*arguments: Any) -> Path:
    raise DaemonError("a demo run is not valid", value="loop timing (loop): 20 overruns (limit 0 to 19)")


@pytest.mark.clock
def test_the_machine_is_measured_with_a_daemon_of_the_rig() -> None:
    found = measured_rate.measure(load_rig("ornl_testbed"))
    assert 1000 <= found.cycles + found.lost <= 6000
    assert f"{found.overruns} overruns" in found.text()


def test_a_spoiled_run_and_the_rest_are_made_in_lockstep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demo_runs, "wall_clock_run", overrun)
    said = Said()
    runs = DemoRuns(load_rig("ornl_testbed"), tmp_path, said)
    runs.run(REQUESTS)
    assert runs.clocks == {"jog": "lockstep", "again": "lockstep"}
    assert list(runs.spoiled) == ["jog"]
    assert "20 overruns" in runs.spoiled["jog"]
    assert any("20 overruns" in line for line in said.lines)
    assert all(read_log(log).complete for log in runs.logs.values())


class Faulty:
    """A daemon whose run ends in a fault, which stays through a disarm."""

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        if method == "status":
            return {"mode": "fault" if self.started else "holding", "log": {"path": "a.mcap"}, "fault": {"text": STALL}}
        self.started = self.started or method == "start"
        return {"run": 1, "validity": "invalid", "reason": f"fault: {STALL}"}

    started = False


STALL = "loop stall (loop): 0.0507 s (limit ≤ 0.05 s)."


def test_a_run_that_ends_in_a_fault_is_told_with_the_fault_and_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("daemon.cli.demo.demo_session.time.sleep", lambda seconds: pytest.fail("it waits for a mode that does not come"))
    with pytest.raises(DaemonError, match="a demo run is not valid: fault: loop stall"):
        demo_session._one_run(cast(Client, Faulty()), {}, lambda status: None)
    client = Faulty()
    client.started = True
    with pytest.raises(DaemonError, match=r"did not change its mode: fault: loop stall .*`longreach host`"):
        demo_session._until_mode(cast(Client, client), "disarmed", lambda status: None)


def test_a_daemon_that_does_not_end_is_killed_and_told() -> None:
    deaf = "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print('deaf', flush=True); time.sleep(600)"
    with subprocess.Popen([sys.executable, "-c", deaf], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"deaf\n"
        with pytest.raises(DaemonError, match="did not end in time"):
            private_daemon.end(process, 0.01)
        assert process.poll() == -signal.SIGKILL


def test_a_rig_with_hardware_is_never_made_up_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demo_runs, "wall_clock_run", overrun)
    with pytest.raises(DaemonError, match="20 overruns"):
        DemoRuns(load_rig("ornl_testbed_can"), tmp_path, Said()).run(REQUESTS)


def test_a_maneuver_that_the_rig_cannot_run_is_no_fault_of_the_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: Any) -> Path:
        raise ManeuverError("outside the workspace")

    monkeypatch.setattr(demo_runs, "wall_clock_run", refuse)
    with pytest.raises(ManeuverError):
        DemoRuns(load_rig("ornl_testbed"), tmp_path, Said()).run(REQUESTS)


@pytest.mark.slow
def test_on_a_machine_that_is_late_it_ends_with_its_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(measured_rate, "measure", lambda loaded: LATE)
    assert main(["demo", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "does not keep 1000 Hz" in said
    assert "adaptive" in said
    assert said.index("tip vibration") < said.index("seen:") < said.index("next:")
    assert said.count("longreach") >= 3


@pytest.mark.slow
def test_for_scripts_it_says_which_clock(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--lockstep", "--out", str(tmp_path), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert set(answer["clock"].values()) == {"lockstep"}
    assert answer["spoiled"] == {}
