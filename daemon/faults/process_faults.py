"""Faults of whole processes: killed, stopped, crowded, out of disk, out of time; and requests of all kinds over the socket."""

from __future__ import annotations

import random
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from math import ceil
from signal import SIGCONT, SIGKILL, SIGSTOP, SIGTERM

import yaml

from daemon.faults import clock_step, small_disk
from daemon.faults.daemon_process import wait_for
from daemon.faults.fault import Fault, Until, Where
from daemon.faults.lockstep_bench import loaded_rig
from daemon.faults.loop_faults import device_limit_ms
from daemon.faults.process_bench import After, Course, Inject, ProcessBench, Setting, Stage, process_trial, told_by_daemon, told_by_log
from daemon.faults.sensor_faults import STOP_MS
from daemon.interlocks import RECORDER_AGE_LIMIT_S, SUPERVISOR_AGE_LIMIT_S
from daemon.protocol import MAX_LINE_BYTES

ASKED_MS = 50.0  # a request goes through the supervisor's event loop before it reaches the loop
DEATHS_MS = 10.0  # between the first process's end and that of the one that writes
LOOK_MS = 1000.0  # of the supervisor at the disk
SLOW_AGE_S = 0.3
END_LIMIT_S = 12.0
GOES_ON = "none: the run goes on"


Make = Callable[..., Fault]


def process_faults(bench: ProcessBench) -> Iterator[Fault]:
    make = partial(_fault, bench)
    yield from _deaths(make)
    yield from _silences(make)
    yield from _io_faults(make)
    yield from _disk_faults(make)
    yield from _intruders(make)
    yield from _requests(make)


def _fault(
    bench: ProcessBench,
    name: str,
    group: str,
    expected: str,
    until: Until,
    limit_ms: float,
    inject: Inject,
    after: After = told_by_daemon,
    *,
    whole: bool = False,
    setting: Setting | None = None,
    impossible: str = "",
) -> Fault:
    course = Course(until, ceil(2.0 * limit_ms) + 1000.0, after, whole, setting)
    run = process_trial(bench, inject, course)
    return Fault(name, group, expected, until, limit_ms, run, where=Where.PROCESSES, impossible=impossible)


def _limit_of_deaths_ms() -> float:
    return device_limit_ms() + DEATHS_MS


def _deaths(make: Make) -> Iterator[Fault]:
    safe, device = Until.SAFE, _limit_of_deaths_ms()
    timed_out = "device time-out; the daemon ends with status 1"
    yield make("control SIGKILLed", "process", timed_out, safe, device, _send(SIGKILL, "control"), _ended)
    yield make("recorder SIGKILLed", "process", "controlled stop: recorder lost", safe, STOP_MS, _send(SIGKILL, "recorder"))
    yield make(
        "supervisor SIGKILLed",
        "process",
        "controlled stop: the daemon ends; then disarmed",
        safe,
        STOP_MS,
        _send(SIGKILL, "supervisor"),
        _left_alone,
    )
    # Control first: if this thread is held up between two kills, whoever still lives cannot act any more.
    everybody = _send(SIGKILL, "control", "recorder", "supervisor")
    yield make("all processes SIGKILLed", "process", "device time-out", safe, device, everybody, lambda stage: "nobody is left")


def _silences(make: Make) -> Iterator[Fault]:
    stall = "device time-out; fault: loop stall"
    yield make(
        "control SIGSTOPped",
        "process",
        stall,
        Until.SAFE,
        device_limit_ms() + DEATHS_MS,
        _send(SIGSTOP, "control"),
        _continued("control"),
        whole=True,
    )
    limit_ms = RECORDER_AGE_LIMIT_S * 1e3 + STOP_MS
    silent = "controlled stop: recorder silent"
    yield make("recorder SIGSTOPped", "process", silent, Until.SAFE, limit_ms, _send(SIGSTOP, "recorder"))
    limit_ms = SUPERVISOR_AGE_LIMIT_S * 1e3 + STOP_MS
    alone = "controlled stop: supervisor alive"
    yield make(
        "supervisor SIGSTOPped", "process", alone, Until.REST, limit_ms, _send(SIGSTOP, "supervisor"), _continued("supervisor"), whole=True
    )
    patience_ms = loaded_rig().rig.loop.overruns.fault_late_s * 1e3
    yield make("control stopped for 20 ms", "process", GOES_ON, Until.RENEWED, patience_ms, _pause_control, whole=True)


def _io_faults(make: Make) -> Iterator[Fault]:
    limit_ms, where = SLOW_AGE_S * 1e3 + ASKED_MS, Setting(text=_rig_with_slow_device)
    for name, number in (("io SIGKILLed", SIGKILL), ("io SIGSTOPped", SIGSTOP)):
        yield make(name, "process", "fault: reservoir_temperature age", Until.SAFE, limit_ms, _send(number, "io"), setting=where)


def _disk_faults(make: Make) -> Iterator[Fault]:
    def where(least_MB: int) -> Setting:
        overrides = (f"interlocks.disk_free_min={least_MB} MB",)
        return Setting(overrides, log_dir=small_disk.mounted, release=small_disk.unmount)

    no_disk = "" if small_disk.possible() else "no file system can be mounted; run as root"
    nearly = where(small_disk.LEAST_FREE_MB)
    full_ms, nearly_ms = RECORDER_AGE_LIMIT_S * 1e3 + STOP_MS, LOOK_MS + STOP_MS
    little = "controlled stop: disk space"
    few, full = (lambda stage: small_disk.fill(stage.directory, 8)), (lambda stage: small_disk.fill(stage.directory, 0))
    yield make("disk nearly full", "disk", little, Until.REST, nearly_ms, few, setting=nearly, impossible=no_disk)
    lost = "controlled stop: recorder"
    yield make("disk full", "disk", lost, Until.SAFE, full_ms, full, setting=where(0), impossible=no_disk)


def _intruders(make: Make) -> Iterator[Fault]:
    patience_ms, renewed = loaded_rig().rig.loop.overruns.fault_late_s * 1e3, Until.RENEWED
    second = "the second is refused with status 1; none: the run goes on"
    yield make("two daemons on one rig", "intruder", second, renewed, patience_ms, _start_second, _second_told, whole=True)
    yield make("garbage on the socket", "intruder", GOES_ON, renewed, patience_ms, _garbage, whole=True)
    stepped = Setting(environment=clock_step.environment)
    for name, seconds in (("wall clock stepped back an hour", -3600), ("wall clock stepped on a day", 86400)):
        yield make(name, "intruder", GOES_ON, renewed, patience_ms, _step_clock(seconds), setting=stepped)


def _requests(make: Make) -> Iterator[Fault]:
    ended = "the daemon ends with status 0"
    yield make("e-stop over the socket", "request", "fault: e-stop", Until.SAFE, ASKED_MS, _ask("estop"), whole=True)
    yield make("disarm over the socket", "request", "disarmed", Until.SAFE, ASKED_MS, _ask("disarm"), whole=True)
    yield make("stop over the socket", "request", "controlled stop", Until.REST, STOP_MS, _ask("stop"), whole=True)
    yield make("SIGTERM", "request", ended, Until.SAFE, STOP_MS, _send(SIGTERM, "supervisor"), _ended)
    yield make("SIGTERM twice", "request", ended, Until.SAFE, ASKED_MS, _terminate_twice, _ended)


def _send(number: int, *names: str) -> Inject:
    return lambda stage: stage.daemon.signal(number, *names)


def _ask(method: str) -> Inject:
    def inject(stage: Stage) -> None:
        stage.client.call(method)

    return inject


def _pause_control(stage: Stage) -> None:
    stage.daemon.signal(SIGSTOP, "control")
    time.sleep(0.02)
    stage.daemon.signal(SIGCONT, "control")


def _terminate_twice(stage: Stage) -> None:
    """The pause keeps the two from becoming one."""
    stage.daemon.signal(SIGTERM, "supervisor")
    time.sleep(0.01)
    stage.daemon.signal(SIGTERM, "supervisor")


def _garbage(stage: Stage) -> None:
    """A thousand lines of noise, one without an end, and a client that leaves in the middle of a word."""
    chance = random.Random(1)
    with socket.socket(socket.AF_UNIX) as intruder, suppress(OSError):
        intruder.connect(str(stage.daemon.socket))
        intruder.settimeout(0.05)
        for _ in range(1000):
            intruder.sendall(chance.randbytes(chance.randrange(200)) + b"\n")
        intruder.sendall(b"x" * (MAX_LINE_BYTES + 1))
    with socket.socket(socket.AF_UNIX) as intruder:
        intruder.connect(str(stage.daemon.socket))
        intruder.sendall(b'{"v": 1, "id": 1, "meth')


def _step_clock(seconds: int) -> Inject:
    return lambda stage: clock_step.step(stage.directory, seconds)


def _ended(stage: Stage) -> str:
    wait_for(lambda: stage.daemon.exit_status() is not None, END_LIMIT_S)
    return f"the daemon ends with status {stage.daemon.exit_status()}"


def _left_alone(stage: Stage) -> str:
    """The control process stops the arm by itself; the supervisor's own end is that of the signal."""
    _ended(stage)
    wait_for(lambda: not stage.daemon.is_alive("control") and not stage.daemon.is_alive("recorder"), END_LIMIT_S)
    return told_by_log(stage)


def _continued(name: str) -> After:
    """Let it go on: the arm must not."""

    def after(stage: Stage) -> str:
        stage.daemon.signal(SIGCONT, name)
        wait_for(lambda: stage.client.call("status")["mode"] in ("fault", "holding"))
        return told_by_daemon(stage)

    return after


def _start_second(stage: Stage) -> None:
    second = subprocess.run(stage.daemon.command, capture_output=True, timeout=60, check=False)
    stage.told = f"the second is refused with status {second.returncode}"


def _second_told(stage: Stage) -> str:
    return f"{stage.told}; {told_by_daemon(stage)}"


def _rig_with_slow_device() -> str:
    """The test bed with its thermometer on a device of its own, which the io process serves."""
    content = yaml.safe_load(loaded_rig().text)
    content["devices"]["gauges"] = {"driver": "sim", "slow": True}
    content["signals"]["reservoir_temperature"] |= {"device": "gauges", "max_age": f"{SLOW_AGE_S} s"}
    return str(yaml.safe_dump(content, sort_keys=False))
