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

from daemon.checks.declared.daemon_health import RECORDER_AGE_LIMIT_S, SUPERVISOR_AGE_LIMIT_S
from daemon.faults.benches.daemon_process import move, wait_for
from daemon.faults.benches.lockstep_bench import loaded_rig
from daemon.faults.benches.process_bench import (
    WAY_DEG,
    After,
    DaemonStart,
    Inject,
    ProcessBench,
    ProcessTarget,
    TrialCourse,
    process_trial,
    reaction_in_log,
    reaction_of_daemon,
)
from daemon.faults.fault import Expected, Fault, FaultPlace, Until
from daemon.faults.injections import clock_step, small_disk
from daemon.faults.loop_faults import device_limit_ms
from daemon.faults.sensor_faults import STOP_MS
from daemon.server.protocol import MAX_LINE_BYTES

REQUEST_MS = 50.0  # a request goes through the supervisor's event loop before it reaches the loop
DEATHS_MS = 10.0  # between the first process's end and that of the one that writes
DISK_POLL_MS = 1000.0  # the supervisor polls the disk this often
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
    expected: Expected,
    inject: Inject,
    after: After = reaction_of_daemon,
    *,
    reusable: bool = False,
    start: DaemonStart | None = None,
    begin: Callable[[ProcessTarget], None] | None = None,
    impossible: str = "",
) -> Fault:
    course = TrialCourse(expected.until, ceil(2.0 * expected.limit_ms) + 1000.0, after, reusable, start, begin)
    run = process_trial(bench, inject, course)
    return Fault(name, group, expected, run, where=FaultPlace.PROCESSES, impossible=impossible)


def _limit_of_deaths_ms() -> float:
    return device_limit_ms() + DEATHS_MS


def _deaths(make: Make) -> Iterator[Fault]:
    safe, device = Until.SAFE, _limit_of_deaths_ms()
    timed_out = "device time-out; the daemon ends with status 1"
    yield make("control SIGKILLed", "process", Expected(timed_out, safe, device), _send(SIGKILL, "control"), _ended)
    yield make("recorder SIGKILLed", "process", Expected("controlled stop: recorder lost", safe, STOP_MS), _send(SIGKILL, "recorder"))
    yield make(
        "supervisor SIGKILLed",
        "process",
        Expected("controlled stop: the daemon ends; then disarmed", safe, STOP_MS),
        _send(SIGKILL, "supervisor"),
        _left_alone,
    )
    # Control first: if this thread is delayed between two kills, the processes that still live cannot act any more.
    everybody = _send(SIGKILL, "control", "recorder", "supervisor")
    yield make("all processes SIGKILLed", "process", Expected("device time-out", safe, device), everybody, lambda target: "nobody is left")


def _silences(make: Make) -> Iterator[Fault]:
    stall = "device time-out; fault: loop stall"
    yield make(
        "control SIGSTOPped",
        "process",
        Expected(stall, Until.SAFE, device_limit_ms() + DEATHS_MS),
        _send(SIGSTOP, "control"),
        _continued("control"),
        reusable=True,
    )
    limit_ms = RECORDER_AGE_LIMIT_S * 1e3 + STOP_MS
    silent = "controlled stop: recorder silent"
    hanging = _send(SIGSTOP, "recorder")
    yield make("recorder SIGSTOPped", "process", Expected(silent, Until.SAFE, limit_ms), hanging, begin=_move_for_long)
    limit_ms = SUPERVISOR_AGE_LIMIT_S * 1e3 + STOP_MS
    alone = "controlled stop: supervisor alive"
    yield make(
        "supervisor SIGSTOPped",
        "process",
        Expected(alone, Until.REST, limit_ms),
        _send(SIGSTOP, "supervisor"),
        _continued("supervisor"),
        reusable=True,
    )
    patience_ms = loaded_rig().rig.loop.overruns.fault_late_s * 1e3
    yield make("control stopped for 20 ms", "process", Expected(GOES_ON, Until.RENEWED, patience_ms), _pause_control, reusable=True)


def _io_faults(make: Make) -> Iterator[Fault]:
    limit_ms, where = SLOW_AGE_S * 1e3 + REQUEST_MS, DaemonStart(text=_rig_with_slow_device)
    for name, number in (("io SIGKILLed", SIGKILL), ("io SIGSTOPped", SIGSTOP)):
        yield make(name, "process", Expected("fault: reservoir_temperature age", Until.SAFE, limit_ms), _send(number, "io"), start=where)


def _disk_faults(make: Make) -> Iterator[Fault]:
    def where(least_MB: int) -> DaemonStart:
        overrides = (f"interlocks.disk_free_min={least_MB} MB",)
        return DaemonStart(overrides, log_dir=small_disk.mounted, release=small_disk.unmount)

    no_disk = "" if small_disk.possible() else "no file system can be mounted; run as root"
    nearly = where(small_disk.LEAST_FREE_MB)
    full_ms, nearly_ms = RECORDER_AGE_LIMIT_S * 1e3 + STOP_MS, DISK_POLL_MS + STOP_MS
    little = "controlled stop: disk space"
    few, full = (lambda target: small_disk.fill(target.directory, 8)), (lambda target: small_disk.fill(target.directory, 0))
    yield make("disk nearly full", "disk", Expected(little, Until.REST, nearly_ms), few, start=nearly, impossible=no_disk)
    lost = "controlled stop: recorder"
    yield make("disk full", "disk", Expected(lost, Until.SAFE, full_ms), full, start=where(0), impossible=no_disk)


def _intruders(make: Make) -> Iterator[Fault]:
    patience_ms, renewed = loaded_rig().rig.loop.overruns.fault_late_s * 1e3, Until.RENEWED
    second = "the second is refused with status 1; none: the run goes on"
    yield make("two daemons on one rig", "intruder", Expected(second, renewed, patience_ms), _start_second, _second_refused, reusable=True)
    yield make("garbage on the socket", "intruder", Expected(GOES_ON, renewed, patience_ms), _garbage, reusable=True)
    stepped = DaemonStart(environment=clock_step.environment)
    for name, seconds in (("wall clock stepped back an hour", -3600), ("wall clock stepped on a day", 86400)):
        yield make(name, "intruder", Expected(GOES_ON, renewed, patience_ms), _step_clock(seconds), start=stepped)


def _requests(make: Make) -> Iterator[Fault]:
    ended = "the daemon ends with status 0"
    yield make("e-stop over the socket", "request", Expected("fault: e-stop", Until.SAFE, REQUEST_MS), _ask("estop"), reusable=True)
    yield make("disarm over the socket", "request", Expected("disarmed", Until.SAFE, REQUEST_MS), _ask("disarm"), reusable=True)
    yield make("stop over the socket", "request", Expected("controlled stop", Until.REST, STOP_MS), _ask("stop"), reusable=True)
    yield make("SIGTERM", "request", Expected(ended, Until.SAFE, STOP_MS), _send(SIGTERM, "supervisor"), _ended)
    yield make("SIGTERM twice", "request", Expected(ended, Until.SAFE, REQUEST_MS), _terminate_twice, _ended)


def _move_for_long(target: ProcessTarget) -> None:
    """Twice as long as the recorder may be silent."""
    move(target.client, WAY_DEG, f"{WAY_DEG / (2.0 * RECORDER_AGE_LIMIT_S):g} deg/s")


def _send(number: int, *names: str) -> Inject:
    return lambda target: target.daemon.signal(number, *names)


def _ask(method: str) -> Inject:
    def inject(target: ProcessTarget) -> None:
        target.client.call(method)

    return inject


def _pause_control(target: ProcessTarget) -> None:
    target.daemon.signal(SIGSTOP, "control")
    time.sleep(0.02)
    target.daemon.signal(SIGCONT, "control")


def _terminate_twice(target: ProcessTarget) -> None:
    """The pause keeps the two from becoming one."""
    target.daemon.signal(SIGTERM, "supervisor")
    time.sleep(0.01)
    target.daemon.signal(SIGTERM, "supervisor")


def _garbage(target: ProcessTarget) -> None:
    """A thousand lines of noise, one without an end, and a client that leaves in the middle of a word."""
    rng = random.Random(1)
    with socket.socket(socket.AF_UNIX) as intruder, suppress(OSError):
        intruder.connect(str(target.daemon.socket))
        intruder.settimeout(0.05)
        for _ in range(1000):
            intruder.sendall(rng.randbytes(rng.randrange(200)) + b"\n")
        intruder.sendall(b"x" * (MAX_LINE_BYTES + 1))
    with socket.socket(socket.AF_UNIX) as intruder:
        intruder.connect(str(target.daemon.socket))
        intruder.sendall(b'{"v": 1, "id": 1, "meth')


def _step_clock(seconds: int) -> Inject:
    return lambda target: clock_step.step(target.directory, seconds)


def _ended(target: ProcessTarget) -> str:
    wait_for(lambda: target.daemon.exit_status() is not None, END_LIMIT_S)
    return f"the daemon ends with status {target.daemon.exit_status()}"


def _left_alone(target: ProcessTarget) -> str:
    """The control process stops the arm by itself; the supervisor's own end is that of the signal."""
    _ended(target)
    wait_for(lambda: not target.daemon.is_alive("control") and not target.daemon.is_alive("recorder"), END_LIMIT_S)
    return reaction_in_log(target)


def _continued(name: str) -> After:
    """Continue the process; the arm must not move on."""

    def after(target: ProcessTarget) -> str:
        target.daemon.signal(SIGCONT, name)
        wait_for(lambda: target.client.call("status")["mode"] in ("fault", "holding"))
        return reaction_of_daemon(target)

    return after


def _start_second(target: ProcessTarget) -> None:
    second = subprocess.run(target.daemon.command, capture_output=True, timeout=60, check=False)
    target.reported = f"the second is refused with status {second.returncode}"


def _second_refused(target: ProcessTarget) -> str:
    return f"{target.reported}; {reaction_of_daemon(target)}"


def _rig_with_slow_device() -> str:
    """The test bed with its thermometer on a device of its own, which the io process serves."""
    content = yaml.safe_load(loaded_rig().text)
    content["devices"]["gauges"] = {"driver": "sim", "slow": True}
    content["signals"]["reservoir_temperature"] |= {"device": "gauges", "max_age": f"{SLOW_AGE_S} s"}
    return str(yaml.safe_dump(content, sort_keys=False))
