"""One trial of a fault of whole processes: a real daemon on the wall clock, the arm in motion, and this process looking at the valves."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random
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
INJECTION_LIMIT_S = 10.0
KEPT_MS = {Until.SAFE: 150.0, Until.REST: 300.0, Until.RENEWED: 3000.0}


@dataclass(slots=True)
class Stage:
    """What a fault may lay its hands on."""

    daemon: DaemonProcess
    client: Client
    directory: Path


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


def process_trial(
    inject: Inject, until: Until, longest_ms: float, after: After | None = None, setting: Setting | None = None
) -> Callable[[Random, Path], Trial]:
    """`after` looks, once the time is measured, whether it stays so, and gives the reaction; left out, the daemon's events give it."""
    chosen = setting or Setting()

    def run(chance: Random, directory: Path) -> Trial:
        try:
            return _trial(inject, until, longest_ms, after or told_by_daemon, chosen, chance, directory)
        finally:
            if chosen.release:
                chosen.release(directory)

    return run


def _trial(inject: Inject, until: Until, longest_ms: float, after: After, setting: Setting, chance: Random, directory: Path) -> Trial:
    environment = setting.environment(directory) if setting.environment else None
    log_dir = setting.log_dir(directory) if setting.log_dir else None
    text = setting.text() if setting.text else None
    with DaemonProcess(directory, setting.overrides, text, environment, log_dir) as daemon, daemon.connect() as client:
        stage = Stage(daemon, client, directory)
        move(client)
        begin = time.monotonic() + 0.3 * chance.random()
        while time.monotonic() < begin:
            time.sleep(LOOK_S)
        register = daemon.register()
        watch = RegisterWatch(register, time.monotonic_ns())
        injection = Thread(target=inject, args=(stage,), daemon=True)  # looking must not wait for what takes long to inject
        injection.start()
        _watch(watch, until, longest_ms)
        injection.join(INJECTION_LIMIT_S)
        times = {Until.SAFE: watch.safe_after_ms, Until.REST: watch.rest_after_ms, Until.RENEWED: watch.longest_pause_ms}
        reaction = ("device time-out; " if watch.timed_out else "") + after(stage)
        if until is Until.SAFE and register.effective(time.monotonic_ns()) != register.safe_values:
            reaction = f"outputs act again: {reaction}"
        return Trial(times[until], reaction)


def _watch(watch: RegisterWatch, until: Until, longest_ms: float) -> None:
    started_ns = now_ns = time.monotonic_ns()
    while (now_ns - started_ns) * 1e-6 < longest_ms:
        now_ns = time.monotonic_ns()
        watch.look(now_ns)
        kept = {Until.SAFE: watch.safe_for_ms, Until.REST: watch.rest_for_ms}.get(until)
        if kept and kept(now_ns) >= KEPT_MS[until]:
            return
        if until is Until.RENEWED and (now_ns - started_ns) * 1e-6 >= KEPT_MS[until]:
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
