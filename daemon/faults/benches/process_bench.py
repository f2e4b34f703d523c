"""One trial of a fault of whole processes: a real daemon on the wall clock, the arm in motion, and this process watching the valves.

A daemon that can be used again after a trial serves the next one too: starting one takes seconds.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any

from config.errors import LongreachError
from daemon.faults.benches.daemon_process import DaemonProcess, move
from daemon.faults.benches.lockstep_bench import reaction_event, short
from daemon.faults.benches.register_watch import RegisterWatch
from daemon.faults.fault import FaultTrial, Until
from daemon.server.protocol import Client
from recording.files.reader import read_log

POLL_S = 0.0002
WATCH_PRIORITY = 70  # below the loop's
INJECTION_LIMIT_S = 10.0
HELD_MS = {Until.SAFE: 150.0, Until.REST: 300.0, Until.RENEWED: 1000.0}
SPEED, WAY_DEG = "20 deg/s", 80


@dataclass(slots=True)
class ProcessTarget:
    """What an injection may change."""

    daemon: DaemonProcess
    client: Client
    directory: Path
    reported: str = ""  # by the injection, for the reaction


@dataclass(frozen=True, slots=True)
class DaemonStart:
    """How the daemon of a trial is started: see DaemonProcess; the functions are given the trial's directory."""

    overrides: Sequence[str] = ()
    text: Callable[[], str] | None = None
    environment: Callable[[Path], Mapping[str, str]] | None = None
    log_dir: Callable[[Path], Path] | None = None
    release: Callable[[Path], None] | None = None


Inject = Callable[[ProcessTarget], None]
After = Callable[[ProcessTarget], str]


class ProcessBench:
    """The daemon shared by trials that need no special start and leave it reusable. Use it in a with statement."""

    def __init__(self) -> None:
        self._target: ProcessTarget | None = None
        self._workspace = TemporaryDirectory(prefix="longreach-processes-")
        self._started = 0

    def __enter__(self) -> ProcessBench:
        return self

    def __exit__(self, *error: object) -> None:
        self.end()
        self._workspace.cleanup()

    def moving(self, begin: Callable[[ProcessTarget], None] | None = None) -> ProcessTarget:
        """The arm in motion, by `begin` or a maneuver. DaemonError when it does not come to that, with a new daemon either."""
        begin = begin or (lambda target: move(target.client, WAY_DEG, SPEED))
        with suppress(LongreachError, OSError):
            return self._moving(begin)
        self.end()
        return self._moving(begin)

    def end(self) -> None:
        """The next trial gets a new daemon."""
        target, self._target = self._target, None
        if target:
            target.client.close()
            target.daemon.end()

    def _moving(self, begin: Callable[[ProcessTarget], None]) -> ProcessTarget:
        if self._target is None:
            self._started += 1
            directory = Path(self._workspace.name) / str(self._started)
            directory.mkdir()
            daemon = DaemonProcess(directory)
            self._target = ProcessTarget(daemon, daemon.connect(), directory)
        begin(self._target)
        return self._target


@dataclass(frozen=True, slots=True)
class TrialCourse:
    """How a trial goes, besides its injection. `after` is called once the time is measured: it checks that the outputs stay safe, and
    gives the reaction.

    `reusable`: the daemon can be used again afterwards. `start`: a daemon of its own, started in another way. `begin` makes the arm
    move, by default a maneuver.
    """

    until: Until
    longest_ms: float
    after: After
    reusable: bool = False
    start: DaemonStart | None = None
    begin: Callable[[ProcessTarget], None] | None = None


def process_trial(bench: ProcessBench, inject: Inject, course: TrialCourse) -> Callable[[Random, Path], FaultTrial]:
    """A trial that injects by `inject` while the rotary joint moves."""

    def run(rng: Random, directory: Path) -> FaultTrial:
        if course.start:
            return _with_own_daemon(inject, course, course.start, rng, directory)
        try:
            trial = _trial(bench.moving(course.begin), inject, course, rng)
        except BaseException:
            bench.end()
            raise
        if not course.reusable:
            bench.end()
        return trial

    return run


def _with_own_daemon(inject: Inject, course: TrialCourse, start: DaemonStart, rng: Random, directory: Path) -> FaultTrial:
    environment = start.environment(directory) if start.environment else None
    log_dir = start.log_dir(directory) if start.log_dir else None
    text = start.text() if start.text else None
    try:
        with DaemonProcess(directory, start.overrides, text, environment, log_dir) as daemon, daemon.connect() as client:
            move(client, WAY_DEG, SPEED)
            return _trial(ProcessTarget(daemon, client, directory), inject, course, rng)
    finally:
        if start.release:
            start.release(directory)


def _trial(target: ProcessTarget, inject: Inject, course: TrialCourse, rng: Random) -> FaultTrial:
    begin = time.monotonic() + 0.3 * rng.random()
    while time.monotonic() < begin:
        time.sleep(POLL_S)
    until, register = course.until, target.daemon.register()
    watch = RegisterWatch(register, time.monotonic_ns())
    injection = Thread(target=inject, args=(target,), daemon=True)  # watching must not wait for what takes long to inject
    injection.start()
    with _realtime_priority():
        _watch(watch, course, injection)
    injection.join(INJECTION_LIMIT_S)
    times = {Until.SAFE: watch.safe_after_ms, Until.REST: watch.rest_after_ms, Until.RENEWED: watch.longest_pause_ms}
    reaction = ("device time-out; " if watch.timed_out else "") + course.after(target)
    if until is Until.SAFE and register.effective(time.monotonic_ns()) != register.safe_values:
        reaction = f"outputs act again: {reaction}"
    return FaultTrial(times[until], reaction)


@contextmanager
def _realtime_priority() -> Iterator[None]:
    """Real-time priority where it is allowed: on a busy machine a late sample would count as the loop's pause."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(WATCH_PRIORITY))
    except PermissionError:
        yield
        return
    try:
        yield
    finally:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def _watch(watch: RegisterWatch, course: TrialCourse, injection: Thread) -> None:
    started_ns = now_ns = time.monotonic_ns()
    while (now_ns - started_ns) * 1e-6 < course.longest_ms or injection.is_alive():
        now_ns = time.monotonic_ns()
        watch.update(now_ns)
        held = {Until.SAFE: watch.safe_for_ms, Until.REST: watch.rest_for_ms}.get(course.until)
        if held and held(now_ns) >= HELD_MS[course.until]:
            return
        if not held and (now_ns - started_ns) * 1e-6 >= HELD_MS[course.until] and not injection.is_alive():
            return
        time.sleep(POLL_S)


def reaction_in_log(target: ProcessTarget) -> str:
    """The first reaction in the recording, for a daemon that has ended."""
    logs = [path for path in (target.directory / "logs").glob("*.mcap") if not path.stem.endswith("-standby")]
    events = [{"name": event.name, "text": event.text} for event in read_log(max(logs)).events]
    began = max((number for number, event in enumerate(events) if event["name"] == "run_started"), default=0)
    found = reaction_event(events[began + 1 :])
    modes = [event["text"] for event in events if event["name"] == "mode"]
    return f"{short(found)}; then {modes[-1].rpartition('→ ')[2]}" if found else "nothing in the log"


def reaction_of_daemon(target: ProcessTarget) -> str:
    """The first reaction in the daemon's events after the run began; what its end says when it no longer answers."""
    try:
        events: list[dict[str, Any]] = target.client.call("events")["events"]
    except (LongreachError, OSError):
        return f"the daemon ended with status {target.daemon.exit_status()}"
    began = max((number for number, event in enumerate(events) if event["name"] == "run_started"), default=0)
    found = reaction_event([event for event in events[began + 1 :] if event["name"] != "overrun"])
    return short(found) if found else "none: the run goes on"
