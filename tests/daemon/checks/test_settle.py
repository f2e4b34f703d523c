"""A run that waits for rest: the number against a sine of known rms, the wait, its limit, its end by a stop or a hang-up."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from config.errors import DaemonError
from daemon.checks.declared.tip_vibration import RMS_FACT, TipVibrationWatch
from daemon.checks.interlocks import rest_checks, rig_facts
from daemon.cli.operate.motion_commands import _tell_waiting
from daemon.ipc.ring import Ring
from daemon.loop.command import CommandRing, LoopCommand
from daemon.server.client_connection import answer_for_client
from daemon.server.protocol import VERSION, encode
from daemon.server.socket_server import serve
from recording.format.fields import field_of_signal
from servo_control.signals import Mode
from tests.support.daemon.lockstep_requests import LockstepRequests, at_once
from tests.support.daemon.rigs import JOG, RIG, simple_rig
from tests.support.daemon.simple_device import SimpleDevice

SENSOR, HZ = "tip.acceleration", round(RIG.rig.loop.rate_Hz)
REAL_SLEEP = asyncio.sleep


@pytest.fixture(autouse=True)
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("daemon.server.request_handlers.asyncio.sleep", at_once)


def swinging(device: SimpleDevice, amplitude: Iterator[float], frequency_Hz: float = 4.0) -> None:
    """The tip's acceleration is a sine about a bias, one sample a cycle."""
    cycle = 0

    def move() -> None:
        nonlocal cycle
        cycle += 1
        device.override[SENSOR] = 0.05 + next(amplitude) * math.sin(2 * math.pi * frequency_Hz * cycle / HZ)

    device.on_read = move


def decaying(start: float, time_constant_s: float) -> Iterator[float]:
    value = start
    while True:
        value *= math.exp(-1 / (HZ * time_constant_s))
        yield value


@pytest.mark.parametrize("frequency_Hz", [2.0, 5.0, 12.0])
@pytest.mark.parametrize("bias", [0.0, 3.0])
def test_the_number_is_the_rms_about_the_mean(frequency_Hz: float, bias: float) -> None:
    facts = rig_facts(RIG.rig)
    values, vibration = facts.blank(), TipVibrationWatch(RIG.rig, facts)
    for cycle in range(10 * HZ):
        values[facts.index(field_of_signal(SENSOR))] = bias + 0.8 * math.sin(2 * math.pi * frequency_Hz * cycle / HZ)
        if cycle == 5 * HZ:
            values[facts.index(field_of_signal(SENSOR))] = math.nan  # a drop-out
        vibration.update(values, 0, 0)
    assert values[facts.index(RMS_FACT)] == pytest.approx(0.8 / math.sqrt(2), rel=0.15)


def test_while_the_sensor_is_gone_nobody_knows_whether_the_tip_is_at_rest() -> None:
    facts = rig_facts(RIG.rig)
    values, vibration, at = facts.blank(), TipVibrationWatch(RIG.rig, facts), facts.index(field_of_signal(SENSOR))
    values[at] = 0.0
    vibration.update(values, 0, 0)
    assert values[facts.index(RMS_FACT)] == 0.0
    values[at] = math.nan
    vibration.update(values, 0, 0)
    assert math.isnan(values[facts.index(RMS_FACT)])
    assert not any(check.passes(values) for check in rest_checks(RIG.rig, facts))


def held(rig: Any) -> LockstepRequests:
    rig.arm()
    lockstep = LockstepRequests(rig)
    lockstep._posted = int(rig.value("commands"))
    return lockstep


def test_a_start_waits_until_the_tip_is_at_rest(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with simple_rig(tmp_path) as (rig, device):
        swinging(device, decaying(2.0, 0.3))
        lockstep = held(rig)
        rig.cycles(50)
        limit = rig.rig.interlocks.start_swing_max_m_per_s2
        assert rig.value(RMS_FACT) > limit
        _tell_waiting(asyncio.run(lockstep.handlers.status({})), 10.0)
        assert "waiting until the arm is at rest, at most 10 s; tip at rest: " in capsys.readouterr().err
        asyncio.run(lockstep.handlers.start({**JOG, "settle_s": 60.0, "countdown_s": 0.0}))
        assert rig.value(RMS_FACT) <= limit


def test_the_wait_has_an_end_that_says_what_moves(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        swinging(device, decaying(2.0, 1e6))
        lockstep = held(rig)
        rig.cycles(HZ)
        refusal = r"not at rest after a wait of 0 s\. tip at rest .*: 1\.\d+ m/s\^2 rms \(limit ≤ 0\.1"
        with pytest.raises(DaemonError, match=refusal):
            asyncio.run(lockstep.handlers.start({**JOG, "settle_s": 0}))
        asyncio.run(lockstep.handlers.start({**JOG, "countdown_s": 0.0}))  # who does not ask is not kept


def test_a_stop_ends_the_wait(tmp_path: Path) -> None:
    async def both(lockstep: LockstepRequests) -> None:
        asked = asyncio.create_task(lockstep.handlers.start({**JOG, "settle_s": 600.0}))
        for _ in range(20):
            await REAL_SLEEP(0)
        assert not asked.done()
        await lockstep.handlers.stop({})
        with pytest.raises(DaemonError, match="it was stopped while it waited"):
            await asked

    with simple_rig(tmp_path) as (rig, device):
        swinging(device, decaying(2.0, 1e6))
        asyncio.run(both(held(rig)))


def test_a_client_that_hangs_up_while_it_waits_has_no_motion_afterwards(tmp_path: Path) -> None:
    """Over the socket: the connection is closed while the arm swings; then the arm comes to rest, and nothing starts."""

    async def ask_and_leave(lockstep: LockstepRequests, swings: list[float]) -> None:
        server = await serve(tmp_path / "s", None, {"start": lockstep.handlers.start})
        _, writer = await asyncio.open_unix_connection(tmp_path / "s")
        writer.write(encode({"v": VERSION, "id": 1, "method": "start", "params": {**JOG, "settle_s": 600.0, "countdown_s": 0.0}}))
        while not lockstep.handlers._starting.locked():
            await REAL_SLEEP(0)
        with pytest.raises(DaemonError, match="another start is being prepared"):
            await lockstep.handlers.start({**JOG})
        writer.close()
        while lockstep.handlers._starting.locked():
            await REAL_SLEEP(0)
        server.close()
        swings.append(0.0)

    with simple_rig(tmp_path) as (rig, device):
        swings = [2.0]
        swinging(device, iter(lambda: swings[-1], None))
        asyncio.run(ask_and_leave(held(rig), swings))
        rig.cycles(5 * HZ)
        assert rig.value(RMS_FACT) < rig.rig.interlocks.start_swing_max_m_per_s2
        assert rig.mode is Mode.HOLDING


@pytest.mark.parametrize("settle_s", [-1, True, "5 s", 601, math.nan])
def test_words_that_are_no_wait(tmp_path: Path, settle_s: Any) -> None:
    with simple_rig(tmp_path) as (rig, _), pytest.raises(DaemonError, match="settle_s is not usable"):
        asyncio.run(held(rig).handlers.start({**JOG, "settle_s": settle_s}))


def test_a_start_is_refused_when_the_arm_stops_holding_while_its_run_is_planned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with simple_rig(tmp_path) as (rig, _):
        lockstep = held(rig)

        async def planned(prepare: Any, *arguments: Any) -> Any:
            start = prepare(*arguments)
            await lockstep.handlers.estop({})
            return start

        monkeypatch.setattr("daemon.server.request_handlers.asyncio.to_thread", planned)
        with pytest.raises(DaemonError, match=r"start refused: fault .*`longreach reset`.* The fault: e-stop was asked for") as refused:
            asyncio.run(lockstep.handlers.start({**JOG, "countdown_s": 0.0}))
        assert refused.value.refusal.limit == "holding with no run under way"
        assert lockstep.history.runs == {}


@pytest.mark.parametrize("what", ["stop", "disarm and arm", "leaves"])
def test_what_takes_a_start_back_while_its_run_is_planned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str) -> None:
    with simple_rig(tmp_path) as (rig, _):
        lockstep = held(rig)

        async def planned(prepare: Any, *arguments: Any) -> Any:
            start = prepare(*arguments)
            if what == "stop":
                await lockstep.handlers.stop({})
            elif what == "leaves":
                answer_for_client(lambda: True)
            else:
                await lockstep.handlers.disarm({})
                await lockstep.handlers.arm({})
            return start

        monkeypatch.setattr("daemon.server.request_handlers.asyncio.to_thread", planned)
        with pytest.raises(
            DaemonError, match="hung up while it was planned" if what == "leaves" else "it was stopped while it was planned"
        ):
            asyncio.run(lockstep.handlers.start({**JOG, "countdown_s": 0.0}))
        rig.cycles(500)
        assert rig.mode is Mode.HOLDING
        assert lockstep.history.runs == {}


def test_a_run_too_long_for_the_loop_is_refused_and_the_next_one_starts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Planned programs go through a ring, which a few thousand repeats would fill."""
    with simple_rig(tmp_path) as (rig, _):
        lockstep = held(rig)
        ring = CommandRing(Ring.create("commands", 64 << 10))
        in_process = lockstep.post

        def post(command: LoopCommand) -> int:
            assert ring.post(command)
            fetched = ring.poll()
            assert fetched is not None
            return in_process(fetched)

        monkeypatch.setattr(lockstep, "post", post)
        with pytest.raises(DaemonError, match=r"the planned run is too long for the loop: 0.0487 MB \(limit: 0.0328 MB\).*--repeat"):
            asyncio.run(lockstep.handlers.start({**JOG, "repeat": 300, "countdown_s": 0.0}))
        assert lockstep.history.runs == {}
        assert asyncio.run(lockstep.handlers.start({**JOG, "countdown_s": 0.0}))["run"] == 1


def test_a_second_start_says_which_run_is_under_way(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, _):
        lockstep = held(rig)
        asyncio.run(lockstep.handlers.start({**JOG, "countdown_s": 60.0}))
        with pytest.raises(DaemonError, match=r"run 1 is announced or under way .*`longreach stop` it"):
            asyncio.run(lockstep.handlers.start({**JOG}))
