"""Driving by hand over the protocol: one client owns a run, every state meets every event, and only a good set point moves the arm."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Iterator
from math import nan
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.errors import DaemonError, LongreachError
from daemon.ipc.mailbox import Mailbox
from daemon.lockstep import LockstepRig
from daemon.loop.set_points import SetPointBox, set_point_mailbox
from daemon.server.set_point_requests import Lateness
from daemon.server.socket_server import answer
from servo_control.signals import Mode, SetPoint, Wanted
from tests.support.daemon.hand_driver import (
    GOOD,
    Driver,
    Owner,
    announced,
    disarmed,
    driving,
    ended,
    ending,
    fault,
    holding,
    maneuver,
    target,
)
from tests.support.daemon.lockstep_requests import LockstepRequests, at_once
from tests.support.daemon.rigs import RIG

MOVED_RAD = 1e-3


@pytest.fixture
def requests(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[LockstepRequests]:
    monkeypatch.setattr(asyncio, "sleep", at_once)
    with LockstepRig(RIG, tmp_path) as rig:
        rig.cycles(300)
        yield LockstepRequests(rig)


STATES = (disarmed, holding, announced, driving, ending, ended, maneuver, fault)
POINTS: dict[str, dict[str, Any]] = {
    "rate": GOOD,
    "target": {"target": {"rotary": 0.5, "prismatic": 1.0}},
    "tip": {"tip_mps": [-0.3, 0.0]},
    "not finite": {"rate": {"rotary": nan}},
    "null": {"rate": {"rotary": None}},
    "too fast": {"rate": {"rotary": 50.0}},
    "beyond": {"target": {"rotary": 3.0, "prismatic": 1.0}},
    "text": {"rate": {"rotary": "fast"}},
    "no such joint": {"rate": {"elbow": 0.1}},
    "half a target": {"target": {"rotary": 0.1}},
    "two things": {**GOOD, "tip_mps": [0.1, 0.0]},
    "nothing": {},
    "late": {**GOOD, "t_s": "now"},
}
ANSWERED = {"rate", "target", "tip", "not finite", "null", "too fast", "beyond", "text"}  # the others are no set points


@pytest.mark.parametrize("state", STATES, ids=lambda state: state.__name__)
@pytest.mark.parametrize("kind", POINTS)
def test_only_a_good_set_point_while_driving_moves_the_arm(
    requests: LockstepRequests, state: Callable[[Driver], Awaitable[None]], kind: str
) -> None:
    async def scene() -> None:
        driver = Driver(requests)
        await state(driver)
        rig, owned = driver.rig, state in (announced, driving)
        mode, before = rig.mode, target(rig)
        try:
            await driver.call("set_point", run=driver.run, **POINTS[kind])
            assert owned
            assert kind in ANSWERED
        except DaemonError:
            assert not owned or kind not in ANSWERED
        rig.cycles(100)
        way = target(rig) - before
        if state is driving:
            good = kind in ("rate", "target", "tip")
            assert rig.mode is (Mode.RUNNING if good else Mode.STOPPING)
            assert (abs(way) > 0.02) == good
        elif state is ending:
            assert rig.mode is Mode.RUNNING
        else:
            assert rig.mode is mode
            assert abs(way) < MOVED_RAD or mode is Mode.FAULT  # where the target follows the arm, which goes on a little
            assert rig.value("rotary.command_V") == 0.0 or mode is not Mode.FAULT

    asyncio.run(scene())


@pytest.mark.parametrize("other", ["another client", "another run"])
def test_nobody_else_drives(requests: LockstepRequests, other: str) -> None:
    async def scene() -> None:
        driver = Driver(requests)
        await driver.driving()
        intruder = Driver(requests) if other == "another client" else driver
        run = driver.run if other == "another client" else driver.run + 1
        before = driver.rig.value("rotary.target_rate")
        with pytest.raises(DaemonError, match="another client drives" if other == "another client" else "no such run"):
            await intruder.call("set_point", run=run, rate={"rotary": -0.3})
        driver.rig.cycles(30)
        assert driver.rig.value("rotary.target_rate") == before > 0.0

    asyncio.run(scene())


@pytest.mark.parametrize(("method", "mode"), [("stop", Mode.HOLDING), ("disarm", Mode.DISARMED), ("estop", Mode.FAULT)])
def test_the_operator_stops_it_as_any_run(requests: LockstepRequests, method: str, mode: Mode) -> None:
    async def scene() -> None:
        driver = Driver(requests)
        await driver.driving()
        await driver.call(method)
        result = await driver.settled()
        assert driver.rig.mode is mode
        assert result["validity"] == "invalid"
        assert ("e-stop" if method == "estop" else method) in result["reason"]
        with pytest.raises(DaemonError, match="the run is over") as refused:
            await driver.call("set_point", run=driver.run, **GOOD)
        assert result["reason"] in str(refused.value)

    asyncio.run(scene())


REASONS = {
    "silence": ({}, "set points arriving"),
    "not finite": (POINTS["not finite"], "set point usable"),
    "text": (POINTS["text"], "set point usable"),
    "too fast": (POINTS["too fast"], "set point in range"),
    "beyond": (POINTS["beyond"], "set point in range"),
}


@pytest.mark.parametrize("what", REASONS)
def test_the_end_says_why_and_the_next_run_may_begin(requests: LockstepRequests, what: str) -> None:
    async def scene() -> None:
        point, check = REASONS[what]
        driver = Driver(requests)
        await driver.driving()
        if point:
            await driver.call("set_point", run=driver.run, **point)
        result = await driver.settled()
        assert result["validity"] == "invalid"
        assert check in result["reason"]
        assert driver.rig.mode is Mode.HOLDING
        driver.run = (await driver.call("stream", countdown_s=0.0))["run"]
        driver.rig.until(lambda: driver.rig.mode is Mode.RUNNING)
        await driver.send(60)
        await driver.call("set_point", run=driver.run, end=True)
        assert (await driver.settled())["validity"] == "valid"

    asyncio.run(scene())


def test_a_set_point_that_was_held_up_ends_the_run(requests: LockstepRequests, monkeypatch: pytest.MonkeyPatch) -> None:
    async def scene() -> None:
        now = [100.0]
        monkeypatch.setattr("daemon.server.set_point_requests.time.monotonic", lambda: now[0])
        driver = Driver(requests)
        await driver.driving()
        await driver.call("set_point", run=driver.run, t_s=5.0, **GOOD)
        now[0] += 0.3
        await driver.call("set_point", run=driver.run, t_s=5.02, **GOOD)
        result = await driver.settled()
        assert "set point in time" in result["reason"]
        assert float(result["reason"].partition("): ")[2].partition(" s")[0]) == pytest.approx(0.28, abs=1e-3)

    asyncio.run(scene())


@pytest.mark.parametrize("state", [announced, driving])
def test_a_client_that_hangs_up_stops_the_arm(requests: LockstepRequests, state: Callable[[Driver], Awaitable[None]]) -> None:
    async def scene() -> None:
        driver = Driver(requests)
        await state(driver)
        driver.owner.gone = True
        for _ in range(20):
            await at_once(0.0)
        driver.rig.cycles(5)
        assert driver.rig.mode is (Mode.HOLDING if state is announced else Mode.STOPPING)
        driver.owner = Owner()
        result = await driver.settled()
        assert ("stop was asked for" if state is announced else "driving client") in result["reason"]

    asyncio.run(scene())


@pytest.mark.parametrize("point", [{"end": True}, {"rate": {"rotary": 10**400}}], ids=["end", "beyond all floats"])
def test_what_ends_driving_takes_back_a_run_that_is_still_announced(requests: LockstepRequests, point: dict[str, Any]) -> None:
    """Its driver is done, so nothing may begin when the countdown is over."""

    async def scene() -> None:
        driver = Driver(requests)
        await announced(driver)
        await driver.call("set_point", run=driver.run, **point)
        driver.rig.cycles(5)
        driver.owner.gone = True
        result = await driver.settled()
        assert "stop was asked for before it began" in result["reason"]
        driver.rig.cycles(20_000)
        assert driver.rig.mode is Mode.HOLDING

    asyncio.run(scene())


@pytest.mark.parametrize("state", [disarmed, announced, driving, maneuver, fault])
def test_a_run_by_hand_begins_only_while_holding(requests: LockstepRequests, state: Callable[[Driver], Awaitable[None]]) -> None:
    async def scene() -> None:
        driver = Driver(requests)
        await state(driver)
        with pytest.raises(DaemonError, match="start refused"):
            await driver.call("stream")

    asyncio.run(scene())


@pytest.mark.parametrize(
    ("params", "text"),
    [
        ({"shaper": {"kind": "zero_delay"}}, r"filter cannot be used .*zero_delay \(limit: none, zv, .*adaptive_zv\)"),
        ({"shaper": 5}, "shaper: wrong kind of value in start: 5"),
        ({"countdown_s": -1.0}, r"countdown out of range: -1\.0 s \(limit: 0 to 60 s\)"),
        ({"maneuver": "jog"}, r"unknown parameter of stream: maneuver \(limit: countdown_s, shaper\)"),
    ],
)
def test_a_wrong_request_is_refused_with_what_is_allowed(requests: LockstepRequests, params: dict[str, Any], text: str) -> None:
    async def scene() -> None:
        driver = Driver(requests)
        await holding(driver)
        with pytest.raises(LongreachError, match=text):
            await driver.call("stream", **params)

    asyncio.run(scene())


def test_nan_in_json_reaches_the_loop_as_such(requests: LockstepRequests) -> None:
    async def scene() -> None:
        driver = Driver(requests)
        await driver.driving()
        line = b'{"v":1,"id":1,"method":"set_point","params":{"run":%d,"rate":{"rotary":NaN}}}' % driver.run
        assert "result" in json.loads(await answer(line, requests.handlers.methods))
        with pytest.raises(DaemonError, match="the run is over: a set point was no finite number"):  # before the loop has said so
            await driver.call("set_point", run=driver.run, **GOOD)
        assert "set point usable" in (await driver.settled())["reason"]

    asyncio.run(scene())


def test_lateness_counts_from_the_quickest_and_forgives_a_clock_that_drifts() -> None:
    lateness = Lateness()
    for number in range(1000):
        assert lateness.of(sent_s=1000.0 + 0.02 * number * (1.0 - 1e-4), now_s=0.02 * number) < 1e-3
    assert lateness.of(sent_s=1020.0, now_s=20.25) == pytest.approx(0.25, abs=0.01)
    assert lateness.of(sent_s=1020.30, now_s=20.27) == 0.0


@given(
    points=st.lists(
        st.builds(SetPoint, st.integers(1, 9), st.sampled_from(Wanted), st.lists(st.floats(), max_size=2).map(tuple), st.floats(0, 1)),
        min_size=1,
        max_size=5,
    )
)
def test_the_box_gives_the_newest_once_and_whole(points: list[SetPoint]) -> None:
    shared = set_point_mailbox(RIG.rig).shared
    writer, reader = SetPointBox(Mailbox(shared)), SetPointBox(Mailbox(shared))
    assert reader.take() is None
    for point in points:
        writer.post(point)
    taken = reader.take()
    assert taken is not None
    assert repr(taken) == repr(points[-1]._replace(wanted=int(points[-1].wanted)))
    assert reader.take() is None
