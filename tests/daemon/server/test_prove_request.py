"""`longreach prove` as a client sees it: refusals that say what stands in the way, and answers that say what was proven."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest

from config.errors import DaemonError, LongreachError
from config.loading.load import apply_overrides, load_rig, rig_from_text
from daemon.cli.operate import prove_command
from daemon.modes.mode_machine import OperatorAction
from daemon.server.proof_request import proof_countdown_s
from servo_control.signals import Mode
from tests.support.daemon.lockstep_requests import LockstepRequests, at_once
from tests.support.daemon.proving_rig import VALVES, pressure, proving_rig
from tests.support.daemon.rigs import simple_rig

REAL_SLEEP = asyncio.sleep


@pytest.fixture(autouse=True)
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("daemon.server.request_handlers.asyncio.sleep", at_once)


def prove(lockstep: LockstepRequests, **params: Any) -> dict[str, Any]:
    lockstep.rig.cycles(2)
    return asyncio.run(lockstep.handlers.prove({"countdown_s": 0.0, **params}))


def released(lockstep: LockstepRequests) -> LockstepRequests:
    lockstep.rig.cycles(2)
    lockstep.rig.post(OperatorAction.RESET)
    lockstep.rig.cycles(3)
    lockstep._posted = int(lockstep.rig.value("commands"))
    return lockstep


def test_a_good_proof_is_answered_with_its_results_and_shown_by_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        lockstep = released(LockstepRequests(rig))
        before = asyncio.run(lockstep.handlers.status({}))["safe_state"]
        assert before == {name: {"demanded": True, "proven_s": pytest.approx(float("nan"), nan_ok=True)} for name in VALVES}
        answer = prove(lockstep, countdown_s=1.0)
        assert (answer["good"], answer["mode"], answer["failures"]) == (True, "disarmed", [])
        assert [result["time_to_safe_s"] for result in answer["results"]] == [0.06] * 4
        after = asyncio.run(lockstep.handlers.status({}))["safe_state"]
        assert all(device["proven_s"] > 0.0 for device in after.values())
        prove_command._show(answer)
        shown = capsys.readouterr().out.splitlines()
        assert shown[0] == "ok  rotary_valve: a missed heartbeat: safe after 60.0 ms, limit 90 ms (as told)"
        assert shown[-1] == "the safe state is proven: `longreach arm`"


def test_a_bad_proof_is_an_answer_and_not_a_refusal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        devices["rotary_valve"].late_s = None  # type: ignore[attr-defined]
        answer = prove(released(LockstepRequests(rig)))
        assert not answer["good"]
        assert [result["ok"] for result in answer["results"]] == [False, True, False, True]
        assert "rotary_valve: a missed heartbeat: not safe within 90 ms" in answer["failures"][0]
        prove_command._show(answer)
        assert "the safe state is NOT proven; the daemon is disarmed" in capsys.readouterr().out


@pytest.mark.parametrize("on", [True, False])
def test_pressure_and_a_latched_e_stop_refuse_with_value_and_limit(tmp_path: Path, on: bool) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=on)
        lockstep = LockstepRequests(rig)
        with pytest.raises(DaemonError) as refusal:
            prove(released(lockstep) if on else lockstep)
        text = str(refusal.value)
        assert "proof refused" in text
        if on:
            assert "rotary.supply_pressure off" in text
            assert "limit ≤ 300000 Pa" in text
            assert "shut-off valve" in text
        else:
            assert "e-stop" in text


def test_an_armed_rig_is_not_proven(tmp_path: Path) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        lockstep = released(LockstepRequests(rig))
        prove(lockstep)
        pressure(devices, on=True)
        rig.cycles(2)
        asyncio.run(lockstep.handlers.arm({}))
        assert rig.mode is Mode.HOLDING
        with pytest.raises(DaemonError, match=r"proof refused: holding \(limit: disarmed\). `longreach disarm` first"):
            prove(lockstep)
        assert rig.mode is Mode.HOLDING


@pytest.mark.parametrize("verb", ["stop", "disarm", "estop"])
def test_a_proof_is_ended_by_every_way_of_stopping_and_its_asker_is_told(tmp_path: Path, verb: str) -> None:
    async def both(lockstep: LockstepRequests) -> tuple[dict[str, Any], str]:
        asked = asyncio.create_task(lockstep.handlers.prove({"countdown_s": 0.0}))
        while lockstep.rig.mode is not Mode.PROVING:
            await REAL_SLEEP(0)
        with pytest.raises(DaemonError, match=r"arming refused: proving .*Wait until the proof is over"):
            await lockstep.handlers.arm({})
        ended = await lockstep.handlers.methods[verb]({})
        return await asked, ended["mode"]

    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        answer, mode = asyncio.run(both(released(LockstepRequests(rig))))
    assert mode == ("fault" if verb == "estop" else "disarmed")
    assert not answer["good"]
    assert any("the proof was given up" in failure for failure in answer["failures"])


def test_a_rig_without_such_devices_needs_no_proof(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, _), pytest.raises(DaemonError, match="no device of this rig can prove its safe state: ornl_testbed"):
        prove(LockstepRequests(rig))


def test_without_a_pressure_sensor_the_operator_must_say_that_it_is_off() -> None:
    content = load_rig("ornl_testbed_can").text
    start, end = content.index("  prismatic.supply_pressure:\n"), content.index("  prismatic.return_pressure:\n")
    rig = rig_from_text(content[:start] + content[end:])
    with pytest.raises(DaemonError, match=r"nothing measures the supply pressure: prismatic\..*--pressure-is-off"):
        proof_countdown_s(rig, {})
    assert proof_countdown_s(rig, {"pressure_is_off": True}) == rig.loop.countdown_s


@pytest.mark.parametrize("params", [{"countdown_s": -1}, {"countdown_s": 61}, {"countdown_s": True}, {"countdown_s": "3 s"}, {"speed": 1}])
def test_words_that_are_no_request(params: dict[str, Any]) -> None:
    rig = rig_from_text(apply_overrides(load_rig("ornl_testbed_can").text, ["loop.countdown=2 s"]))
    with pytest.raises(LongreachError):
        proof_countdown_s(rig, params)
