"""`longreach prove` as a client sees it: refusals that say what stands in the way, and answers that say what was proven."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
from office import Office, at_once
from proving_rig import VALVES, pressure, proving_rig
from rigs import simple_rig

from config.errors import DaemonError, LongreachError
from config.load import apply_overrides, load_rig, rig_from_text
from control.signals import Mode
from daemon.cli import prove_command
from daemon.modes import Event
from daemon.proof_request import proof_countdown_s

REAL_SLEEP = asyncio.sleep


@pytest.fixture(autouse=True)
def no_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("daemon.desk.asyncio.sleep", at_once)


def prove(office: Office, **params: Any) -> dict[str, Any]:
    office.rig.cycles(2)
    return asyncio.run(office.desk.prove({"countdown_s": 0.0, **params}))


def released(office: Office) -> Office:
    office.rig.cycles(2)
    office.rig.post(Event.RESET)
    office.rig.cycles(3)
    office._posted = int(office.rig.value("commands"))
    return office


def test_a_good_proof_is_answered_with_its_results_and_shown_by_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        office = released(Office(rig))
        before = asyncio.run(office.desk.status({}))["safe_state"]
        assert before == {name: {"demanded": True, "proven_s": pytest.approx(float("nan"), nan_ok=True)} for name in VALVES}
        answer = prove(office, countdown_s=1.0)
        assert (answer["good"], answer["mode"], answer["failures"]) == (True, "disarmed", [])
        assert [result["time_to_safe_s"] for result in answer["results"]] == [0.06] * 4
        after = asyncio.run(office.desk.status({}))["safe_state"]
        assert all(device["proven_s"] > 0.0 for device in after.values())
        prove_command._show(answer)
        shown = capsys.readouterr().out.splitlines()
        assert shown[0] == "ok  rotary_valve: a missed heartbeat: safe after 60.0 ms, limit 90 ms (as told)"
        assert shown[-1] == "the safe state is proven: `longreach arm`"


def test_a_bad_proof_is_an_answer_and_not_a_refusal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        devices["rotary_valve"].late_s = None  # type: ignore[attr-defined]
        answer = prove(released(Office(rig)))
        assert not answer["good"]
        assert [result["ok"] for result in answer["results"]] == [False, True, False, True]
        assert "rotary_valve: a missed heartbeat: not safe within 90 ms" in answer["failures"][0]
        prove_command._show(answer)
        assert "the safe state is NOT proven; the daemon is disarmed" in capsys.readouterr().out


@pytest.mark.parametrize("on", [True, False])
def test_pressure_and_a_latched_e_stop_refuse_with_value_and_limit(tmp_path: Path, on: bool) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=on)
        office = Office(rig)
        with pytest.raises(DaemonError) as refusal:
            prove(released(office) if on else office)
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
        office = released(Office(rig))
        prove(office)
        pressure(devices, on=True)
        rig.cycles(2)
        asyncio.run(office.desk.arm({}))
        assert rig.mode is Mode.HOLDING
        with pytest.raises(DaemonError, match=r"proof refused: holding \(limit: disarmed\). `longreach disarm` first"):
            prove(office)
        assert rig.mode is Mode.HOLDING


@pytest.mark.parametrize("verb", ["stop", "disarm", "estop"])
def test_a_proof_is_ended_by_every_way_of_stopping_and_its_asker_is_told(tmp_path: Path, verb: str) -> None:
    async def both(office: Office) -> tuple[dict[str, Any], str]:
        asked = asyncio.create_task(office.desk.prove({"countdown_s": 0.0}))
        while office.rig.mode is not Mode.PROVING:
            await REAL_SLEEP(0)
        with pytest.raises(DaemonError, match=r"arming refused: proving .*Wait until the proof is over"):
            await office.desk.arm({})
        ended = await office.desk.methods[verb]({})
        return await asked, ended["mode"]

    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        answer, mode = asyncio.run(both(released(Office(rig))))
    assert mode == ("fault" if verb == "estop" else "disarmed")
    assert not answer["good"]
    assert any("the proof was given up" in failure for failure in answer["failures"])


def test_a_rig_without_such_devices_needs_no_proof(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, _), pytest.raises(DaemonError, match="no device of this rig can prove its safe state: ornl_testbed"):
        prove(Office(rig))


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
