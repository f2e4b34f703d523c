"""A run that waits for rest: the number against a sine of known rms, the wait, its limit, its end by a stop or a hang-up."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from office import Office, at_once
from rigs import JOG, RIG, simple_rig
from simple_device import SimpleDevice

from config.errors import DaemonError
from control.signals import Mode
from daemon.cli.motion_commands import _tell_waiting
from daemon.facts import SWING_FACT, Facts
from daemon.protocol import VERSION, encode
from daemon.socket_server import serve
from daemon.swing import Swing
from recording.fields import field_of_signal
from recording.layout import CycleLayout

SENSOR, HZ = "tip.acceleration", round(RIG.rig.loop.rate_Hz)
REAL_SLEEP = asyncio.sleep


@pytest.fixture(autouse=True)
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("daemon.desk.asyncio.sleep", at_once)


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
    facts = Facts(RIG.rig, CycleLayout.of_rig(RIG.rig))
    values, swing = facts.blank(), Swing(RIG.rig, facts)
    for cycle in range(10 * HZ):
        values[facts.index(field_of_signal(SENSOR))] = bias + 0.8 * math.sin(2 * math.pi * frequency_Hz * cycle / HZ)
        if cycle == 5 * HZ:
            values[facts.index(field_of_signal(SENSOR))] = math.nan  # a drop-out
        swing.update(values)
    assert values[facts.index(SWING_FACT)] == pytest.approx(0.8 / math.sqrt(2), rel=0.15)


def held(rig: Any) -> Office:
    rig.arm()
    office = Office(rig)
    office._posted = int(rig.value("commands"))
    return office


def test_a_start_waits_until_the_tip_is_at_rest(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with simple_rig(tmp_path) as (rig, device):
        swinging(device, decaying(2.0, 0.3))
        office = held(rig)
        rig.cycles(50)
        limit = rig.rig.interlocks.start_swing_max_m_per_s2
        assert rig.value(SWING_FACT) > limit
        _tell_waiting(asyncio.run(office.desk.status({})), 10.0)
        assert "waiting until the arm is at rest, at most 10 s; tip at rest: " in capsys.readouterr().err
        asyncio.run(office.desk.start({**JOG, "settle_s": 60.0, "countdown_s": 0.0}))
        assert rig.value(SWING_FACT) <= limit


def test_the_wait_has_an_end_that_says_what_moves(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        swinging(device, decaying(2.0, 1e6))
        office = held(rig)
        rig.cycles(HZ)
        refusal = r"not at rest after a wait of 0 s\. tip at rest .*: 1\.\d+ m/s\^2 rms \(limit ≤ 0\.1"
        with pytest.raises(DaemonError, match=refusal):
            asyncio.run(office.desk.start({**JOG, "settle_s": 0}))
        asyncio.run(office.desk.start({**JOG, "countdown_s": 0.0}))  # who does not ask is not kept


def test_a_stop_ends_the_wait(tmp_path: Path) -> None:
    async def both(office: Office) -> None:
        asked = asyncio.create_task(office.desk.start({**JOG, "settle_s": 600.0}))
        for _ in range(20):
            await REAL_SLEEP(0)
        assert not asked.done()
        await office.desk.stop({})
        with pytest.raises(DaemonError, match="it was stopped while it waited"):
            await asked

    with simple_rig(tmp_path) as (rig, device):
        swinging(device, decaying(2.0, 1e6))
        asyncio.run(both(held(rig)))


def test_a_client_that_hangs_up_while_it_waits_has_no_motion_afterwards(tmp_path: Path) -> None:
    """Over the socket: the connection is closed while the arm swings; then the arm comes to rest, and nothing starts."""

    async def ask_and_leave(office: Office, swings: list[float]) -> None:
        server = await serve(tmp_path / "s", None, {"start": office.desk.start})
        _, writer = await asyncio.open_unix_connection(tmp_path / "s")
        writer.write(encode({"v": VERSION, "id": 1, "method": "start", "params": {**JOG, "settle_s": 600.0, "countdown_s": 0.0}}))
        while not office.desk._starting.locked():
            await REAL_SLEEP(0)
        with pytest.raises(DaemonError, match="another start is being prepared"):
            await office.desk.start({**JOG})
        writer.close()
        while office.desk._starting.locked():
            await REAL_SLEEP(0)
        server.close()
        swings.append(0.0)

    with simple_rig(tmp_path) as (rig, device):
        swings = [2.0]
        swinging(device, iter(lambda: swings[-1], None))
        asyncio.run(ask_and_leave(held(rig), swings))
        rig.cycles(5 * HZ)
        assert rig.value(SWING_FACT) < rig.rig.interlocks.start_swing_max_m_per_s2
        assert rig.mode is Mode.HOLDING


@pytest.mark.parametrize("settle_s", [-1, True, "5 s", 601, math.nan])
def test_words_that_are_no_wait(tmp_path: Path, settle_s: Any) -> None:
    with simple_rig(tmp_path) as (rig, _), pytest.raises(DaemonError, match="settle_s is not usable"):
        asyncio.run(held(rig).desk.start({**JOG, "settle_s": settle_s}))
