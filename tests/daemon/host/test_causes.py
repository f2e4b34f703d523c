"""What makes a computer late, read from a made-up /proc and /sys: found, with what to do, and silent where the system says nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from daemon.host.causes import causes, stolen_ticks

CPU = "sys/devices/system/cpu"


def computer(root: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text + "\n")
    return root


LAPTOP = {
    f"{CPU}/cpu0/cpufreq/scaling_governor": "powersave",
    f"{CPU}/cpu1/cpufreq/scaling_governor": "performance",
    f"{CPU}/cpu0/cpuidle/state0/name": "POLL",
    f"{CPU}/cpu0/cpuidle/state0/latency": "0",
    f"{CPU}/cpu0/cpuidle/state3/name": "C6",
    f"{CPU}/cpu0/cpuidle/state3/latency": "133",
    f"{CPU}/smt/active": "1",
    "proc/cpuinfo": "flags\t: fpu vme",
    "sys/bus/usb-serial/devices/ttyUSB0/latency_timer": "16",
    "proc/sys/kernel/sched_rt_runtime_us": "950000",
    "proc/sys/kernel/sched_rt_period_us": "1000000",
}


def test_each_cause_has_its_value_and_what_to_do(tmp_path: Path) -> None:
    found = {cause.name: cause for cause in causes(computer(tmp_path, LAPTOP))}
    assert found["governor"].value == "performance, powersave"
    assert "cpupower" in found["governor"].next_step
    assert found["idle states"].value == "C6 133 us"
    assert "/dev/cpu_dma_latency" in found["idle states"].next_step
    assert "smt/control" in found["hardware threads"].next_step
    assert "16 ms" in found["USB adapter ttyUSB0"].value
    assert "sys/bus/usb-serial/devices/ttyUSB0/latency_timer" in found["USB adapter ttyUSB0"].next_step
    assert found["hypervisor"].value == "none"
    assert found["real-time limit"].value == "50 ms of every 1000 ms are kept for other work"
    assert "isolcpus" in found["real-time limit"].next_step


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({f"{CPU}/cpu0/cpufreq/scaling_governor": "performance"}, "governor"),
        ({f"{CPU}/cpu0/cpuidle/state3/latency": "2"}, "idle states"),
        ({"dev/cpu_dma_latency": ""}, "idle states"),
        ({f"{CPU}/smt/active": "0"}, "hardware threads"),
        ({"proc/sys/kernel/sched_rt_runtime_us": "-1"}, "real-time limit"),
        ({"sys/bus/usb-serial/devices/ttyUSB0/latency_timer": "1"}, "USB adapter ttyUSB0"),
    ],
)
def test_where_nothing_is_wrong_there_is_nothing_to_do(tmp_path: Path, change: dict[str, str], name: str) -> None:
    found = {cause.name: cause for cause in causes(computer(tmp_path, LAPTOP | change))}
    assert found[name].next_step == ""


def can(root: Path, driver: str, frames: int, release: str) -> Path:
    """A CAN adapter on USB beside a network card that is none."""
    net = {"can0/type": "280", "can0/tx_queue_len": str(frames), "eth0/type": "1", "eth0/tx_queue_len": "1000"}
    files = {f"sys/class/net/{name}": text for name, text in net.items()}
    computer(root, LAPTOP | files | {"proc/sys/kernel/osrelease": release, f"sys/bus/usb/drivers/{driver}/bind": ""})
    (root / "sys/class/net/can0/device").mkdir()
    (root / "sys/class/net/can0/device/driver").symlink_to(root / f"sys/bus/usb/drivers/{driver}")
    (root / "sys/class/net/can0/device/subsystem").symlink_to(root / "sys/bus/usb")
    return root


@pytest.mark.parametrize(
    ("driver", "frames", "release", "advice"),
    [
        ("gs_usb", 10, "6.6.2-rt", ""),
        ("gs_usb", 10, "6.12.0", ""),
        ("gs_usb", 10, "6.1.0-21-rt-amd64", "Before Linux 6.6 gs_usb changes the order of frames"),
        ("peak_usb", 10, "5.10.0", ""),
        ("peak_usb", 128, "6.12.0", "ip link set can0 txqueuelen 10"),
    ],
)
def test_a_can_adapter_is_judged_by_its_queue_and_its_driver(tmp_path: Path, driver: str, frames: int, release: str, advice: str) -> None:
    found = [cause for cause in causes(can(tmp_path, driver, frames, release)) if cause.name.startswith("CAN ")]
    assert [(cause.name, cause.value) for cause in found] == [("CAN can0", f"{driver} on usb, a queue of {frames} frames")]
    assert advice in found[0].next_step
    assert bool(advice) == bool(found[0].next_step)


def stat(number: int, name: str, parent: int, priority: int, policy: int) -> dict[str, str]:
    """As `man 5 proc` has it: the policy is field 41."""
    fields = ["S", str(parent), *(["0"] * 35), str(priority), str(policy), "0", "0", "0"]
    return {f"proc/{number}/stat": f"{number} ({name}) {' '.join(fields)}"}


def test_programs_with_a_real_time_priority_are_named(tmp_path: Path) -> None:
    every = LAPTOP | stat(18, "migration/0", 2, 99, os.SCHED_FIFO) | stat(300, "bash", 1, 0, os.SCHED_OTHER)
    every |= stat(400, "a (b) c", 1, 1, os.SCHED_RR) | stat(401, "of this process", os.getpid(), 80, os.SCHED_FIFO)
    found = {cause.name: cause for cause in causes(computer(tmp_path, every))}["real-time programs"]
    assert found.value == "a (b) c (process 400, priority 1)"
    assert "chrt" in found.next_step


ASKS = """
import os, signal
try:
    os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
except PermissionError:
    pass
print(os.getpid(), os.sched_getscheduler(0) == os.SCHED_RR, flush=True)
signal.pause()
"""


def test_a_program_that_asked_for_a_real_time_priority_is_found() -> None:
    beside = ["sh", "-c", '"$0" -c "$1" & wait', sys.executable, ASKS]  # no child of this process
    with subprocess.Popen(beside, stdout=subprocess.PIPE, text=True) as shell:
        assert shell.stdout is not None
        number, granted = shell.stdout.readline().split()
        try:
            found = {cause.name: cause for cause in causes()}["real-time programs"].value
        finally:
            os.kill(int(number), signal.SIGKILL)
    if granted == "False":
        pytest.skip("this user may not have a real-time priority")
    assert f"(process {number}, priority 1)" in found


def test_a_virtual_machine_says_what_its_host_took(tmp_path: Path) -> None:
    root = computer(
        tmp_path, {"proc/cpuinfo": "flags\t: fpu hypervisor", "proc/stat": "cpu 10 0 20 60 0 0 0 10 0 0\ncpu0 5 0 10 30 0 0 0 5"}
    )
    assert stolen_ticks(root) == (10, 100)
    found = {cause.name: cause for cause in causes(root, stolen=0.1)}
    assert "10.0 % of the time" in found["hypervisor"].value
    assert "idle states" in found
    assert found["governor"].next_step == ""


def test_a_system_that_says_nothing_is_no_error(tmp_path: Path) -> None:
    assert stolen_ticks(tmp_path) == (0, 1)
    assert causes(tmp_path)
