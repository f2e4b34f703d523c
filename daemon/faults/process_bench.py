"""One trial of a fault of whole processes: a real daemon on the wall clock, the arm in motion, and this process looking at the valves.

A daemon that is as good as new after a trial serves the next one too: starting one takes seconds.
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
from daemon.faults.daemon_process import DaemonProcess, move
from daemon.faults.fault import Trial, Until
from daemon.faults.lockstep_bench import reaction_event, short
from daemon.faults.register_watch import RegisterWatch
from daemon.protocol import Client
from recording.reader import read_log

LOOK_S = 0.0002
LOOK_PRIORITY = 70  # below the loop's
INJECTION_LIMIT_S = 10.0
KEPT_MS = {Until.SAFE: 150.0, Until.REST: 300.0, Until.RENEWED: 1000.0}
SPEED, WAY_DEG = "20 deg/s", 80


@dataclass(slots=True)
class Stage:
    """What a fault may lay its hands on."""

    daemon: DaemonProcess
    client: Client
    directory: Path
    told: str = ""  # by the injection, for the reaction


@dataclass(frozen=True, slots=True)
class Setting:
    """How the daemon of a trial is started: see DaemonProcess; the functions are given the trial's directory."""

    overrides: Sequence[str] = ()
    text: Callable[[], str] | None = None
    environment: Callable[[Path], Mapping[str, str]] | None = None
    log_dir: Callable[[Path], Path] | None = None
    release: Callable[[Path], None] | None = None


Inject = Callable[[Stage], None]
After = Callable[[Stage], str]


class ProcessBench:
    """The daemon of the trials that want the ordinary one and leave it whole. Use it in a with statement."""

    def __init__(self) -> None:
        self._stage: Stage | None = None
        self._place = TemporaryDirectory(prefix="longreach-processes-")
        self._started = 0

    def __enter__(self) -> ProcessBench:
        return self

    def __exit__(self, *error: object) -> None:
        self.end()
        self._place.cleanup()

    def moving(self) -> Stage:
        """The arm in motion. DaemonError when it does not come to that, with a new daemon either."""
        with suppress(LongreachError, OSError):
            return self._moving()
        self.end()
        return self._moving()

    def end(self) -> None:
        """The next trial gets a new daemon."""
        stage, self._stage = self._stage, None
        if stage:
            stage.client.close()
            stage.daemon.end()

    def _moving(self) -> Stage:
        if self._stage is None:
            self._started += 1
            directory = Path(self._place.name) / str(self._started)
            directory.mkdir()
            daemon = DaemonProcess(directory)
            self._stage = Stage(daemon, daemon.connect(), directory)
        move(self._stage.client, WAY_DEG, SPEED)
        return self._stage


@dataclass(frozen=True, slots=True)
class Course:
    """How a trial goes, besides its injection. `after` looks, once the time is measured, whether it stays so, and gives the reaction.

    `whole`: the daemon is as good as new afterwards. `setting`: a daemon of its own, started in another way.
    """

    until: Until
    longest_ms: float
    after: After
    whole: bool = False
    setting: Setting | None = None


def process_trial(bench: ProcessBench, inject: Inject, course: Course) -> Callable[[Random, Path], Trial]:
    def run(chance: Random, directory: Path) -> Trial:
        if course.setting:
            return _with_own_daemon(inject, course, course.setting, chance, directory)
        try:
            trial = _trial(bench.moving(), inject, course, chance)
        except BaseException:
            bench.end()
            raise
        if not course.whole:
            bench.end()
        return trial

    return run


def _with_own_daemon(inject: Inject, course: Course, setting: Setting, chance: Random, directory: Path) -> Trial:
    environment = setting.environment(directory) if setting.environment else None
    log_dir = setting.log_dir(directory) if setting.log_dir else None
    text = setting.text() if setting.text else None
    try:
        with DaemonProcess(directory, setting.overrides, text, environment, log_dir) as daemon, daemon.connect() as client:
            move(client, WAY_DEG, SPEED)
            return _trial(Stage(daemon, client, directory), inject, course, chance)
    finally:
        if setting.release:
            setting.release(directory)


def _trial(stage: Stage, inject: Inject, course: Course, chance: Random) -> Trial:
    begin = time.monotonic() + 0.3 * chance.random()
    while time.monotonic() < begin:
        time.sleep(LOOK_S)
    until, register = course.until, stage.daemon.register()
    watch = RegisterWatch(register, time.monotonic_ns())
    injection = Thread(target=inject, args=(stage,), daemon=True)  # looking must not wait for what takes long to inject
    injection.start()
    with _attentive():
        _watch(watch, course, injection)
    injection.join(INJECTION_LIMIT_S)
    times = {Until.SAFE: watch.safe_after_ms, Until.REST: watch.rest_after_ms, Until.RENEWED: watch.longest_pause_ms}
    reaction = ("device time-out; " if watch.timed_out else "") + course.after(stage)
    if until is Until.SAFE and register.effective(time.monotonic_ns()) != register.safe_values:
        reaction = f"outputs act again: {reaction}"
    return Trial(times[until], reaction)


@contextmanager
def _attentive() -> Iterator[None]:
    """Real-time priority where it is allowed: on a busy machine a look that comes late would be counted as the loop's pause."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(LOOK_PRIORITY))
    except PermissionError:
        yield
        return
    try:
        yield
    finally:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def _watch(watch: RegisterWatch, course: Course, injection: Thread) -> None:
    started_ns = now_ns = time.monotonic_ns()
    while (now_ns - started_ns) * 1e-6 < course.longest_ms or injection.is_alive():
        now_ns = time.monotonic_ns()
        watch.look(now_ns)
        kept = {Until.SAFE: watch.safe_for_ms, Until.REST: watch.rest_for_ms}.get(course.until)
        if kept and kept(now_ns) >= KEPT_MS[course.until]:
            return
        if not kept and (now_ns - started_ns) * 1e-6 >= KEPT_MS[course.until] and not injection.is_alive():
            return
        time.sleep(LOOK_S)


def told_by_log(stage: Stage) -> str:
    """The first reaction in the recording, for a daemon that nobody can ask any more."""
    logs = [path for path in (stage.directory / "logs").glob("*.mcap") if not path.stem.endswith("-standby")]
    events = [{"name": event.name, "text": event.text} for event in read_log(max(logs)).events]
    began = max((number for number, event in enumerate(events) if event["name"] == "run_started"), default=0)
    found = reaction_event(events[began + 1 :])
    modes = [event["text"] for event in events if event["name"] == "mode"]
    return f"{short(found)}; then {modes[-1].rpartition('→ ')[2]}" if found else "nothing in the log"


def told_by_daemon(stage: Stage) -> str:
    """The first reaction in the daemon's events after the run began; what its end says when it no longer answers."""
    try:
        events: list[dict[str, Any]] = stage.client.call("events")["events"]
    except (LongreachError, OSError):
        return f"the daemon ended with status {stage.daemon.exit_status()}"
    began = max((number for number, event in enumerate(events) if event["name"] == "run_started"), default=0)
    found = reaction_event([event for event in events[began + 1 :] if event["name"] != "overrun"])
    return short(found) if found else "none: the run goes on"
