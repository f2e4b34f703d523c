"""The daemon as it is started on a rig: real processes, wall clock, socket. Waits on conditions, never on time."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from config.errors import ConfigError, DaemonError, ManeuverError
from daemon.cli.main import main
from daemon.server.protocol import Client
from drivers.output_register import OutputRegister
from recording.evaluation.replay import reexecute
from recording.files.reader import Log, read_log
from servo_control.signals import Mode
from tests.support.daemon.running_daemon import RunningDaemon, arm, terminate, until

pytestmark = pytest.mark.clock

SHORT_JOG = {"maneuver": {"name": "jog"}, "parameters": {"by": "1 deg"}, "countdown_s": 0.2}
LONG_JOG = {"maneuver": {"name": "jog"}, "parameters": {"by": "40 deg"}, "countdown_s": 0.0}


@pytest.fixture(scope="module")
def daemon(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDaemon]:
    with RunningDaemon(tmp_path_factory.mktemp("daemon")) as running:
        running.wait_until_ready().close()
        yield running


@pytest.fixture
def client(daemon: RunningDaemon) -> Iterator[Client]:
    with Client(daemon.socket) as connected:
        yield connected
        connected.call("disarm")


def missed_share(log: Log) -> float:
    """Of the periods of the run, by the times of its rows."""
    times_s = log.columns["t_s"][log.columns["mode"] == Mode.RUNNING]
    periods = round((times_s[-1] - times_s[0]) * 1000) + 1
    return (periods - len(times_s)) / len(times_s)


def effective(daemon: RunningDaemon) -> tuple[float, ...]:
    """What the valves do, read past the daemon."""
    register = OutputRegister.attach(daemon.runtime / "plant.outputs")
    values = register.effective(time.monotonic_ns())
    register.close()
    return values


def mode(client: Client) -> str:
    return str(client.call("status")["mode"])


def test_after_the_start_it_is_disarmed_safe_and_refuses_to_arm_or_start(daemon: RunningDaemon, client: Client) -> None:
    status = client.call("status")
    assert status["mode"] == "disarmed"
    assert status["estop"] == "latched"
    assert effective(daemon) == (0.0, 0.0)
    with pytest.raises(DaemonError, match=r"arming refused.*e-stop.*longreach reset"):
        client.call("arm")
    with pytest.raises(DaemonError, match=r"start refused: disarmed.*longreach arm"):
        client.call("start", **SHORT_JOG)
    failed = [check for check in client.call("checks")["checks"] if not check["ok"]]
    assert [check["name"] for check in failed] == ["e-stop"]


def test_arm_run_disarm_gives_a_whole_log_that_re_executes(daemon: RunningDaemon, client: Client) -> None:
    arm(client)
    run = client.call("start", **SHORT_JOG)
    with pytest.raises(DaemonError, match="no run under way"):
        client.call("start", **SHORT_JOG)
    status = client.call("status")
    assert status["run"]["maneuver"] == "jog"
    result = client.call("wait", run=run["run"], timeout_s=20)
    log_path = Path(client.call("status")["log"]["path"])
    client.call("disarm")
    until(lambda: read_log(log_path).complete)
    log = read_log(log_path)
    names = [event.name for event in log.events]
    assert [name for name in names if name != "overrun"] == [
        "mode",
        "mode",
        "countdown",
        "mode",
        "run_started",
        "mode",
        "run_ended",
        "mode",
    ]
    assert bool(result["reason"]) == (missed_share(log) > 0.05), "a busy machine may miss many periods, and then the run says so"
    assert result["validity"] == ("invalid" if result["reason"] else "valid")
    assert log.metadata["recording"]["clock"] == "wall"
    assert "realtime_real_time_priority" in log.metadata["recording"]
    assert reexecute(log_path).identical


def test_e_stop_is_safe_and_latched_over_the_socket(daemon: RunningDaemon, client: Client) -> None:
    arm(client)
    client.call("start", **LONG_JOG)
    until(lambda: any(value != 0.0 for value in effective(daemon)))
    client.call("estop")
    assert effective(daemon) == (0.0, 0.0)
    assert client.call("status")["fault"]["text"] == "e-stop was asked for"
    with pytest.raises(DaemonError, match="longreach reset"):
        client.call("arm")
    assert client.call("reset") == {"mode": "disarmed"}
    assert client.call("status")["fault"] is None


def test_stop_ends_the_run_and_holds(client: Client) -> None:
    arm(client)
    run = client.call("start", **LONG_JOG)
    until(lambda: mode(client) == "running")
    client.call("stop")
    until(lambda: mode(client) == "holding")
    assert client.call("wait", run=run["run"], timeout_s=5) == {
        "run": run["run"],
        "validity": "invalid",
        "reason": "stop was asked for",
        "log": client.call("status")["log"]["path"],
    }


def test_errors_of_a_request_come_back_with_their_class(client: Client) -> None:
    arm(client)
    with pytest.raises(ConfigError, match="paper_line"):
        client.call("start", maneuver={"name": "paper_lime"})
    with pytest.raises(ManeuverError, match="limit"):
        client.call("start", maneuver={"name": "jog"}, parameters={"by": "170 deg"})
    with pytest.raises(DaemonError, match="no such run"):
        client.call("wait", run=99, timeout_s=1)
    assert mode(client) == "holding"


def test_events_are_numbered_and_can_be_followed(client: Client) -> None:
    before = client.call("events")["last"]
    arm(client)
    events = client.call("events", since=before)["events"]
    assert [event["n"] for event in events] == list(range(before + 1, before + 1 + len(events)))
    assert any(event["text"] == "arming → holding" for event in events)
    assert {maneuver["name"] for maneuver in client.call("maneuvers")["maneuvers"]} >= {"jog", "paper_line"}


def test_a_second_daemon_in_the_same_place_is_refused(daemon: RunningDaemon) -> None:
    with RunningDaemon(daemon.directory) as second:
        assert second.process.wait(30) == 1
        assert f"process {daemon.process.pid}" in second.text()
        assert "another daemon uses this runtime directory" in second.text()
    with Client(daemon.socket) as client:
        assert client.call("status")["mode"] == "disarmed"


def test_systemd_hears_ready_watchdog_and_stopping_and_sigterm_stops_in_order(tmp_path: Path) -> None:
    notifications = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    notifications.bind(str(tmp_path / "notify"))
    notifications.settimeout(60)
    with RunningDaemon(tmp_path, environment={"NOTIFY_SOCKET": str(tmp_path / "notify")}) as daemon:
        with daemon.wait_until_ready() as client:
            assert notifications.recv(4096).startswith(b"READY=1")
            assert notifications.recv(4096).startswith(b"WATCHDOG=1\nSTATUS=")
            set_off(client)
        terminate(daemon)
        assert daemon.process.wait(15) == 0
        assert daemon.all_ended()
        assert effective(daemon) == (0.0, 0.0)
        log = read_log(daemon.latest_log())
        assert log.complete
        assert 4 in log.columns["mode"], "a controlled stop came first"
        assert any("the daemon ends" in event.text for event in log.events)
        assert not daemon.socket.exists()
        received = b""
        while b"STOPPING=1" not in received:
            received = notifications.recv(4096)
    notifications.close()


def test_a_frozen_loop_starves_the_watchdog_times_out_the_valves_and_faults_when_it_wakes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    notifications = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    notifications.bind(str(tmp_path / "notify"))
    with RunningDaemon(tmp_path, environment={"NOTIFY_SOCKET": str(tmp_path / "notify")}) as daemon, daemon.wait_until_ready() as client:
        arm(client)
        client.call("start", **LONG_JOG)
        until(lambda: mode(client) == "running" and effective(daemon) != (0.0, 0.0))
        os.kill(daemon.child("control"), signal.SIGSTOP)
        until(lambda: effective(daemon) == (0.0, 0.0), 0.3)
        until(lambda: not pending(notifications, wait_s=1.0), 10.0)  # systemd would kill the daemon now
        assert client.call("status")["loop"]["silent_s"] > 0.5
        assert client.call("checks")["checks"][0]["name"] == "loop stands still"
        os.kill(daemon.child("control"), signal.SIGCONT)
        until(lambda: mode(client) == "fault")
        assert client.call("status")["loop"]["silent_s"] == 0.0
        until(lambda: told(client).count("loop_moves_again") == 1)
        assert told(client).count("loop_silent") == 1
        assert "loop stall" in client.call("status")["fault"]["text"]
        assert main(["--socket", str(daemon.socket), "why"]) == 1
        assert "a fault is latched: loop stall" in capsys.readouterr().out
        assert effective(daemon) == (0.0, 0.0)
        until(lambda: b"WATCHDOG=1" in pending(notifications, wait_s=1.0))
    notifications.close()


def set_off(client: Client) -> None:
    """Armed, and a long jog under way."""
    arm(client)
    client.call("start", **LONG_JOG)
    until(lambda: mode(client) == "running")


def told(client: Client) -> list[str]:
    return [event["name"] for event in client.call("events", since=0)["events"]]


def pending(notifications: socket.socket, wait_s: float) -> bytes:
    """Everything that was notified until now, or the next within `wait_s`; empty when nothing came."""
    notifications.settimeout(wait_s)
    try:
        received = notifications.recv(4096)
    except TimeoutError:
        return b""
    notifications.setblocking(False)
    with suppress(BlockingIOError):
        while True:
            received += notifications.recv(4096)
    return received


@pytest.mark.usefixtures("terminal_can_end")
def test_the_end_of_its_terminal_stops_the_arm_in_order(tmp_path: Path) -> None:
    """An SSH connection that breaks sends SIGHUP to every process of the daemon."""
    with RunningDaemon(tmp_path) as daemon:
        with daemon.wait_until_ready() as client:
            set_off(client)
        for process in (daemon.child("control"), daemon.child("recorder"), daemon.process.pid):
            os.kill(process, signal.SIGHUP)
        assert daemon.process.wait(15) == 0
        log = read_log(daemon.latest_log())
        assert log.complete
        assert int(Mode.STOPPING) in log.columns["mode"]
        assert not daemon.socket.exists()


def test_a_second_sigterm_does_not_wait_for_the_arm(tmp_path: Path) -> None:
    with RunningDaemon(tmp_path) as daemon:
        with daemon.wait_until_ready() as client:
            set_off(client)
        terminate(daemon)
        terminate(daemon)
        until(lambda: effective(daemon) == (0.0, 0.0), 1.0)
        assert daemon.process.wait(10) == 0
        assert read_log(daemon.latest_log()).complete


def test_a_supervisor_that_dies_ends_the_rest_in_order_and_the_next_start_is_disarmed(tmp_path: Path) -> None:
    with RunningDaemon(tmp_path) as daemon:
        with daemon.wait_until_ready() as client:
            set_off(client)
        os.kill(daemon.process.pid, signal.SIGKILL)
        until(daemon.all_ended, 10.0)
        assert effective(daemon) == (0.0, 0.0)
        assert read_log(daemon.latest_log()).complete
        with RunningDaemon(tmp_path) as again, again.wait_until_ready() as client:
            assert mode(client) == "disarmed"
            assert client.call("status")["run"] is None


def test_a_supervisor_that_fails_stops_the_arm_in_order_and_closes_the_log(tmp_path: Path) -> None:
    """A mistake of ours in the supervisor must not kill the process that moves the arm."""
    trouble = tmp_path / "trouble"
    (tmp_path / "sitecustomize.py").write_text(
        "import os, shutil\n"
        "usage = shutil.disk_usage\n"
        "def disk_usage(path):\n"
        f"    if os.path.exists({str(trouble)!r}):\n"
        "        raise RuntimeError('a mistake of ours')\n"
        "    return usage(path)\n"
        "shutil.disk_usage = disk_usage\n"
    )
    before = {"PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])}
    with RunningDaemon(tmp_path, environment=before) as daemon:
        with daemon.wait_until_ready() as client:
            set_off(client)
        trouble.touch()
        assert daemon.process.wait(20) == 1
        assert "a mistake of ours" in daemon.text()
        assert effective(daemon) == (0.0, 0.0)
        log = read_log(daemon.latest_log())
        assert log.complete
        assert Mode.STOPPING in log.columns["mode"]


def test_the_folder_of_the_logs_may_be_moved_away_while_the_arm_holds(tmp_path: Path) -> None:
    with RunningDaemon(tmp_path) as daemon, daemon.wait_until_ready() as client:
        arm(client)
        daemon.logs.rename(tmp_path / "elsewhere")
        until(daemon.logs.is_dir)
        assert mode(client) == "holding"
        client.call("disarm")
        arm(client)
        client.call("disarm")
        until(lambda: read_log(daemon.latest_log()).complete)


def test_a_log_that_is_deleted_during_a_run_stops_it(tmp_path: Path) -> None:
    """Everything written after it would be lost without a word."""
    with RunningDaemon(tmp_path) as daemon, daemon.wait_until_ready() as client:
        set_off(client)
        shutil.rmtree(daemon.logs)
        until(lambda: mode(client) == "fault", 5.0)
        assert any("the log was deleted" in event["text"] for event in client.call("events", since=0)["events"])
        arm(client)
        client.call("disarm")
        until(lambda: read_log(daemon.latest_log()).complete)


def test_a_dead_control_process_ends_the_daemon_with_its_log_closed(tmp_path: Path) -> None:
    with RunningDaemon(tmp_path) as daemon:
        with daemon.wait_until_ready() as client:
            arm(client)
        os.kill(daemon.child("control"), signal.SIGKILL)
        assert daemon.process.wait(10) == 1
        log = read_log(daemon.latest_log())
        assert log.complete
        assert log.metadata["closing"]["ended_by"] == "the control process died"
        assert "killed by SIGKILL" in daemon.text()


def test_a_dead_recorder_is_a_fault_and_a_reset_brings_a_new_one(tmp_path: Path) -> None:
    with RunningDaemon(tmp_path) as daemon, daemon.wait_until_ready() as client:
        set_off(client)
        os.kill(daemon.child("recorder"), signal.SIGKILL)
        until(lambda: mode(client) == "fault", 5.0)
        assert "recorder lost" in client.call("status")["fault"]["text"]
        arm(client)
        assert any(event["name"] == "recorder_started" for event in client.call("events")["events"])
        client.call("disarm")
        until(lambda: read_log(daemon.latest_log()).complete)
