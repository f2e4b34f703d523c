"""SIGKILL of every process of the daemon at random moments of a maneuver: the valves become safe, the log keeps all but its last
250 ms, recovery makes it whole, and the next daemon is disarmed.

What the valves do is read from the output register by this process, which the daemon knows nothing of.
"""

from __future__ import annotations

import os
import random
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

from daemon.server.protocol import Client
from drivers.output_register import OutputRegister
from recording.files.reader import Log, read_log
from recording.files.recover import recover
from tests.support.daemon.running_daemon import RunningDaemon, arm, until

pytestmark = pytest.mark.clock

VICTIMS = ("control", "recorder", "supervisor", "everybody")
KILLS_EACH = 13
WORKERS = 2
LONGEST_LOSS_S = 0.25
SLACK_S = 0.1  # of this reader's own looks, on a busy machine
STOP_LIMIT_S = 8.0  # controlled stop, then safe outputs
LONG_JOG = {"maneuver": {"name": "jog"}, "parameters": {"by": "40 deg", "speed": "10 deg/s"}, "countdown_s": 0.0}
BACK = {**LONG_JOG, "parameters": {"by": "-40 deg", "speed": "10 deg/s"}}


@dataclass(frozen=True)
class Outcome:
    victim: str
    in_motion: bool
    safe_after_s: float
    lost_s: float
    recovered: bool


def effective(register: OutputRegister) -> tuple[float, ...]:
    return register.effective(time.monotonic_ns())


def seconds_until_safe(register: OutputRegister, limit_s: float) -> float:
    started = time.monotonic()
    until(lambda: effective(register) == (0.0, 0.0), limit_s)
    return time.monotonic() - started


def victims(daemon: RunningDaemon, victim: str) -> list[int]:
    processes = {"control": daemon.child("control"), "recorder": daemon.child("recorder"), "supervisor": daemon.process.pid}
    return list(processes.values()) if victim == "everybody" else [processes[victim]]


def kill_once(daemon: RunningDaemon, client: Client, victim: str, wait_s: float, out: Path) -> Outcome:
    """Arm, move, kill after `wait_s` of motion, and look at what is left."""
    register = OutputRegister.attach(daemon.runtime / "plant.outputs")
    arm(client)
    position = client.call("status")["joints"]["rotary"]["position"]
    client.call("start", **(LONG_JOG if position < 0.0 else BACK))
    until(lambda: client.call("status")["mode"] != "holding")
    moves_on = time.monotonic() + wait_s
    until(lambda: time.monotonic() >= moves_on)
    in_motion = client.call("status")["mode"] == "running" and effective(register) != (0.0, 0.0)
    log_path = Path(client.call("status")["log"]["path"])
    killed_unix_ns = time.time_ns()
    for pid in victims(daemon, victim):
        os.kill(pid, signal.SIGKILL)
    alone = victim in ("control", "everybody")  # nobody is left to write: the device's own time-out
    safe_after_s = seconds_until_safe(register, STOP_LIMIT_S)
    if alone:
        assert safe_after_s <= register.timeout_s + SLACK_S, f"{victim}: safe after {safe_after_s:.3f} s"
    if victim == "recorder":
        until(lambda: client.call("status")["mode"] == "fault")
        assert "recorder" in client.call("status")["fault"]["text"]
        daemon.process.send_signal(signal.SIGTERM)
    until(daemon.all_ended, 20.0)
    assert effective(register) == (0.0, 0.0)
    log = read_log(log_path)
    lost_s = (killed_unix_ns - last_stamp_ns(log)) * 1e-9
    return Outcome(victim, in_motion, safe_after_s, lost_s, recovered(log, out))


def last_stamp_ns(log: Log) -> float:
    """Unix time of the last row: the recording says when its first row was."""
    started = datetime.fromisoformat(log.metadata["recording"]["started_utc"]).timestamp()
    t_s = log.columns["t_s"]
    return (started + float(t_s[-1] - t_s[0])) * 1e9


def recovered(log: Log, out: Path) -> bool:
    """Recovery gives a whole file with every row that could be read, none missing in between."""
    if log.complete:
        return True
    recover(log.path, out)
    whole = read_log(out)
    assert whole.cycles == log.cycles
    assert set(np.diff(whole.columns["cycle"].astype(np.int64))) <= {1}
    return "recovered" in whole.metadata or whole.complete


def one_worker(directory: Path, plan: list[tuple[str, float]]) -> list[Outcome]:
    """Daemon after daemon in one directory; each must find everything disarmed, whatever happened to the one before."""
    outcomes = []
    for number, (victim, wait_s) in enumerate(plan):
        with RunningDaemon(directory) as daemon, daemon.wait_until_ready() as client:
            status = client.call("status")
            assert (status["mode"], status["run"]) == ("disarmed", None)
            register = OutputRegister.attach(daemon.runtime / "plant.outputs")
            assert effective(register) == (0.0, 0.0)
            outcomes.append(kill_once(daemon, client, victim, wait_s, directory / f"recovered-{number}.mcap"))
    return outcomes


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(900)
def test_kills_at_random_moments(tmp_path: Path) -> None:
    chance = random.Random(4)
    plan = [(victim, chance.uniform(0.0, 2.0)) for victim in VICTIMS for _ in range(KILLS_EACH)]
    chance.shuffle(plan)
    directories = [tmp_path / str(number) for number in range(WORKERS)]
    for directory in directories:
        directory.mkdir()
    with ThreadPoolExecutor(WORKERS) as pool:
        parts = pool.map(one_worker, directories, [plan[number::WORKERS] for number in range(WORKERS)])
        outcomes = [outcome for part in parts for outcome in part]
    report(outcomes)
    assert len(outcomes) == len(VICTIMS) * KILLS_EACH
    assert sum(outcome.in_motion for outcome in outcomes) >= 0.8 * len(outcomes), "most kills hit a moving arm"
    assert all(outcome.lost_s <= LONGEST_LOSS_S for outcome in outcomes)
    assert all(outcome.recovered for outcome in outcomes)


def report(outcomes: list[Outcome]) -> None:
    for victim in VICTIMS:
        mine = [outcome for outcome in outcomes if outcome.victim == victim]
        safe, lost = max(outcome.safe_after_s for outcome in mine), max(outcome.lost_s for outcome in mine)
        moving = sum(outcome.in_motion for outcome in mine)
        print(f"{victim:11} {len(mine)} kills, {moving} in motion: safe after ≤ {safe:.3f} s, lost ≤ {lost:.3f} s of log")
