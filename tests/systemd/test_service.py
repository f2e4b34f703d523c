"""longreachd under a real systemd (systemd-nspawn): every promise of the unit, kept.

What a container on this host cannot show: LimitRTPRIO= and LimitMEMLOCK= (the capabilities do the work) and CAN (no such kernel).
"""

from __future__ import annotations

import json
import math
import re
import shutil
import time

import numpy as np
import pytest

from recording.files.check import check_log
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.systemd.longreach_service import REPORTS, UNIT, Service
from tests.systemd.nspawn_machine import Machine, eventually

pytestmark = [pytest.mark.slow, pytest.mark.clock, pytest.mark.timeout(300)]

CONTROLLED_STOP_S = 5.0  # docs: how to stop
START_LIMIT_BURST = 5
PAGE_LIMIT_S = 200.0  # with what is left over of the processor, and the first page compiles the plant


def test_installed_command_works_from_anywhere_for_anybody(installed: Service) -> None:
    """Not from the checkout: the packages and their data are all in the installed copy."""
    answer = installed.machine.run("setpriv", "--reuid", "nobody", "--clear-groups", "longreach", "check", "ornl_testbed", "--json")
    assert json.loads(answer.stdout)["good"], answer
    where = installed.machine.run("/opt/longreach/bin/python", "-c", "import config; print(config.__file__)").stdout
    assert where.startswith("/opt/longreach/lib/")


def test_systemd_finds_nothing_to_say_about_the_installed_files(installed: Service) -> None:
    """It ignores what it does not understand and says so in the journal only."""
    answer = installed.machine.run("systemd-analyze", "verify", f"/etc/systemd/system/{UNIT}")
    assert (answer.returncode, answer.stderr) == (0, "")
    installed.systemctl("start", "systemd-networkd")
    said = installed.machine.run("journalctl", "-u", "systemd-networkd", "-o", "cat").stdout
    installed.systemctl("stop", "systemd-networkd", "systemd-networkd.socket")
    assert "Enumeration completed" in said
    assert "10-can0" not in said, said


def test_udev_finds_nothing_to_say_either(installed: Service) -> None:
    if shutil.which("udevadm") is None:
        pytest.skip("not installed: udevadm (Debian: udev)")
    link = installed.machine.run("udevadm", "test-builtin", "net_setup_link", "/sys/class/net/lo").stderr
    assert "Parsed configuration file" in link
    assert "10-can0.link:" not in link, link
    rules = installed.machine.run("udevadm", "test", "/sys/class/net/lo").stderr
    assert "Reading rules file: /etc/udev/rules.d/70-longreach.rules" in rules
    assert "70-longreach.rules:" not in rules, rules


def test_ready_only_when_disarmed_and_the_devices_answered(installed: Service) -> None:
    """The first start compiles the simulated plant, so there is time to look. Until READY there is no socket to ask for motion."""
    installed.systemctl("start", "--no-block", UNIT)
    while (state := installed.show("ActiveState")) != "active":
        assert state in ("activating", "inactive"), installed.journal()
        early = installed.socket.exists()
        assert not early or installed.show("ActiveState") == "active"
    status = installed.status()
    assert status["mode"] == "disarmed"
    assert status["estop"] == "latched"
    assert status["cycle"] > 0
    assert all(math.isfinite(joint["position"]) for joint in status["joints"].values())
    assert installed.show("StatusText").startswith("disarmed")


def test_a_device_that_does_not_answer_is_never_ready(installed: Service) -> None:
    """The refusal is in the journal, and after the last permitted start systemd gives up."""
    machine = installed.machine
    installed.systemctl("stop", UNIT)
    rig = machine.path("/etc/longreach/rig.yaml")
    good = rig.read_text()
    try:
        rig.write_text(good.replace("driver: sim", "driver: absent"))
        answer = machine.run("systemctl", "start", UNIT)
        assert answer.returncode == 1
        assert installed.show("ActiveState") != "active"
        assert "there is no driver 'absent'" in installed.journal()
        assert not installed.socket.exists()
    finally:
        rig.write_text(good)


def test_group_may_use_the_socket_and_nobody_else(service: Service) -> None:
    run = service.machine.run
    run("useradd", "--user-group", "--groups", "longreach", "pilot", check=True)
    run("useradd", "--user-group", "outsider", check=True)
    allowed = run("setpriv", "--reuid", "pilot", "--regid", "pilot", "--init-groups", "longreach", "status", "--json")
    assert json.loads(allowed.stdout)["mode"] == "disarmed"
    refused = run("setpriv", "--reuid", "outsider", "--regid", "outsider", "--init-groups", "longreach", "status")
    assert refused.returncode == 1
    assert "group" in refused.stderr
    assert run("stat", "-c", "%a %U %G", "/run/longreach/longreach.sock").stdout.strip() == "660 longreach longreach"
    assert run("stat", "-c", "%a %U %G", "/var/log/longreach").stdout.strip() == "750 longreach longreach"


def test_a_run_gets_its_page_from_the_unit_of_the_reports(service: Service) -> None:
    """Enabled as the guide says. Before the tests that leave many runs: each of them would get its page first."""
    service.systemctl("enable", "--now", REPORTS)
    try:
        service.hold()
        run = service.call("start", maneuver={"name": "jog"}, countdown_s=0.0)["run"]
        assert service.call("wait", run=run, timeout_s=30.0)["validity"] == "valid"
        log = service.recording()
        service.call("disarm")
        page = log.with_name(f"{log.stem}-run-{run}.html")
        eventually("the page is there", page.exists, PAGE_LIMIT_S)
        said = service.machine.run("journalctl", "-u", REPORTS, "-o", "cat").stdout
        assert f"/{page.name}" in said, said
    finally:
        service.systemctl("disable", "--now", REPORTS)
    assert "Not simulated" not in page.read_text(), "the plant is compiled in this sandbox too"
    assert service.machine.run("stat", "-c", "%a %U %G", f"/var/log/longreach/{page.name}").stdout.strip() == "640 longreach longreach"
    assert service.mode() == "disarmed"


def test_real_time_is_granted_to_the_loop_and_to_nothing_else(service: Service) -> None:
    policy = {role: service.machine.run("chrt", "-p", service.pid(role)).stdout for role in ("main", "control", "recorder")}
    assert "SCHED_FIFO" in policy["control"]
    assert "priority: 80" in policy["control"]
    assert "SCHED_OTHER" in policy["main"]
    assert "SCHED_OTHER" in policy["recorder"]
    control = service.process_facts("control")
    locked_kB, resident_kB = (int(control[key].split()[0]) for key in ("VmLck", "VmRSS"))
    assert locked_kB > 0.9 * resident_kB
    rows = {row["name"]: row for row in service.call("checks")["checks"]}
    assert rows["real-time priority"]["severity"] == "info"
    assert rows["locked memory"]["severity"] == "info"


@pytest.mark.parametrize("role", ["main", "control", "recorder"])
def test_every_process_is_confined(service: Service, role: str) -> None:
    facts = service.process_facts(role)
    ipc_lock, sys_nice = 1 << 14, 1 << 23  # linux/capability.h
    assert int(facts["CapBnd"], 16) == ipc_lock | sys_nice
    assert facts["NoNewPrivs"] == "1"
    assert facts["Seccomp"] == "2"
    assert "0" not in facts["Uid"].split()


def test_sandbox_from_inside(installed: Service) -> None:
    """A probe in a unit with the service's own lines, only its program and the names of its places differ."""
    machine = installed.machine
    machine.path("/tmp/outside").write_text("x")
    machine.path("/usr/local/lib/probe.py").write_text(machine.path("/srv/longreach/tests/systemd/sandbox_probe.py").read_text())
    lines = machine.path(f"/etc/systemd/system/{UNIT}").read_text()
    lines = re.sub(r"(?m)^(Type|NotifyAccess|ExecStart|ExecStopPost|Restart|Watchdog\w+|Timeout\w+)=.*\n", "", lines)
    lines = lines.replace("Directory=longreach", "Directory=longreach-probe").replace("C/longreach", "C/longreach-probe")
    program = "ExecStart=/opt/longreach/bin/python /usr/local/lib/probe.py\nType=oneshot\nStandardOutput=truncate:/run/probe.json\n"
    machine.path("/run/systemd/system/probe.service").write_text(lines.replace("[Service]\n", f"[Service]\n{program}"))
    machine.run("systemctl", "daemon-reload", check=True)
    machine.run("systemctl", "start", "probe.service", check=True)
    assert json.loads(machine.path("/run/probe.json").read_text()) == {
        "write /etc/longreach": "EROFS",
        "write /opt/longreach": "EROFS",
        "write /usr": "EROFS",
        "write logs": "done",
        "write cache": "done",
        "write runtime": "done",
        "write tmp": "done",
        "see outside tmp": "ENOENT",
        "list home": "EACCES",
        "see process 1": "ENOENT",
        "socket AF_UNIX": "done",
        "socket AF_INET": "done",
        "socket AF_PACKET": "EAFNOSUPPORT",
        "socket AF_NETLINK": "EAFNOSUPPORT",
        "user namespace": "EPERM",
        "change personality": "EPERM",
        "set-group-id file": "EPERM",
        "become root": "EPERM",
        "SCHED_FIFO": "done",
        "lock memory": "done",
        "executable memory": "done",
    }


@pytest.mark.parametrize("role", ["control", "main"])
def test_a_hang_is_ended_by_the_watchdog(service: Service, role: str) -> None:
    """The loop stops, or the supervisor does: systemd kills all of it and starts it anew, disarmed."""
    service.hold()
    loop = service.machine.path(f"/proc/{service.pid('control')}")
    service.signal("STOP", role)
    old = service.show("MainPID")
    killed_after_s = eventually("it was killed", lambda: service.show("MainPID") != old, 5)
    assert killed_after_s < 2.0  # WatchdogSec=1 and the time since it was last fed
    assert eventually("the loop is gone too", lambda: not loop.exists(), 5) < 0.5
    service.restarted()
    said = service.journal()
    assert "Watchdog timeout (limit 1s)!" in said
    assert "Failed with result 'watchdog'" in said
    assert service.mode() == "disarmed"


def came_back_disarmed(service: Service) -> None:
    service.restarted()
    status = service.status()
    assert (status["mode"], status["estop"], status["run"]) == ("disarmed", "latched", None)


def test_when_the_supervisor_is_killed_the_outputs_are_made_safe_and_the_log_is_closed(service: Service) -> None:
    service.move()
    path, last_s = service.recording(), service.status()["t_s"]
    service.signal("KILL", "main")
    came_back_disarmed(service)
    log = read_log(path)
    assert log.complete
    assert Mode(int(log.columns["mode"][-1])) not in (Mode.RUNNING, Mode.STOPPING)
    assert log.columns["rotary.command_V"][-1] == log.columns["prismatic.command_V"][-1] == 0.0
    assert log.columns["t_s"][-1] < last_s + CONTROLLED_STOP_S


def test_when_all_of_it_is_killed_the_cut_log_is_repaired(service: Service) -> None:
    service.move()
    cut, last_s = service.recording(), service.status()["t_s"]
    service.systemctl("kill", "--signal=KILL", UNIT)
    came_back_disarmed(service)
    repaired = read_log(cut.with_name(f"{cut.stem}-recovered.mcap"))
    assert not read_log(cut).complete
    assert "recovered" in repaired.metadata
    assert repaired.damage.sentences == []
    assert repaired.columns["t_s"][-1] > last_s - 0.25  # what the recorder may lose
    assert repaired.columns["mode"][-1] == Mode.RUNNING


def test_restart_during_a_maneuver_ends_disarmed(service: Service) -> None:
    service.move()
    service.systemctl("restart", UNIT)
    status = service.status()
    assert (status["mode"], status["estop"], status["run"]) == ("disarmed", "latched", None)
    before = [joint["position"] for joint in status["joints"].values()]
    eventually("a thousand cycles more", lambda: service.status()["cycle"] > status["cycle"] + 1000, 10)
    after = [joint["position"] for joint in service.status()["joints"].values()]
    assert np.allclose(before, after, atol=2e-3)  # rad and m: at rest but for the drift of closed valves


def test_stop_during_a_maneuver_is_controlled_and_closes_the_log(service: Service) -> None:
    service.move()
    path = service.recording()
    started = time.monotonic()
    service.systemctl("stop", UNIT)
    assert time.monotonic() - started < CONTROLLED_STOP_S
    assert service.show("Result") == "success"
    log = read_log(path)
    assert log.complete
    report = check_log(path)
    assert report.good, report.text()
    modes = [Mode(int(value)) for value in log.columns["mode"]]
    stopping = modes.index(Mode.STOPPING)
    assert Mode.RUNNING in modes[:stopping]
    assert Mode.FAULT not in modes
    assert Mode.RUNNING not in modes[stopping:]
    speed = np.abs(log.columns["rotary.target_velocity"][stopping:]) if "rotary.target_velocity" in log.columns else np.zeros(1)
    assert speed[-1] == 0.0
    assert not list(service.logs.glob(f"{path.stem}-recovered.mcap"))


def test_a_crash_loop_ends_where_the_unit_says(service: Service) -> None:
    """Each of the five starts it allows is killed as soon as it is there."""
    service.fresh()
    kills, last = 0, ""
    while service.show("ActiveState") != "failed":
        pid = service.show("MainPID")
        if pid not in ("0", last):
            service.machine.run("kill", "-s", "KILL", pid)
            kills, last = kills + 1, pid
        assert kills <= START_LIMIT_BURST
    assert kills == START_LIMIT_BURST
    assert "Start request repeated too quickly" in service.journal()
    assert service.machine.run("systemctl", "start", UNIT).returncode == 1
    service.fresh()
    assert service.mode() == "disarmed"


def test_installing_over_a_running_daemon_is_refused(service: Service) -> None:
    answer = service.machine.run("make", "-C", "/srv/longreach", "install", "FROM_VENV=/srv/venv")
    assert answer.returncode != 0
    assert "systemctl stop longreachd" in answer.stderr
    assert service.mode() == "disarmed"


def test_uninstalling_keeps_logs_and_configuration(service: Service) -> None:
    """And installing again keeps the rig file that is there. Last, because it takes the service away."""
    machine: Machine = service.machine
    service.systemctl("stop", UNIT)
    logs = sorted(path.name for path in service.logs.iterdir())
    assert logs
    rig = machine.path("/etc/longreach/rig.yaml")
    rig.write_text(rig.read_text() + "# ours\n")
    machine.run("make", "-C", "/srv/longreach", "uninstall", check=True)
    assert not machine.path("/opt/longreach").exists()
    assert machine.run("systemctl", "cat", UNIT).returncode == 1
    assert sorted(path.name for path in service.logs.iterdir()) == logs
    assert rig.read_text().endswith("# ours\n")
    answer = machine.run("make", "-C", "/srv/longreach", "install", "FROM_VENV=/srv/venv", check=True, limit_s=200)
    assert "kept  /etc/longreach/rig.yaml" in answer.stdout
    assert rig.read_text().endswith("# ours\n")
    service.fresh()
    assert service.mode() == "disarmed"
