"""The proof of the safe state in the loop: what it needs, what ends it, and that arming asks for it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from config.errors import DaemonError
from daemon.checks.safe_state import ATTACHMENT
from daemon.lockstep import LockstepRig
from daemon.loop.command import LoopCommand
from daemon.modes.mode_machine import OperatorAction
from recording.evaluation.replay import reexecute
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.support.daemon.proving_rig import OPEN_CYCLES, PRESSURES, VALVES, pressure, proving_rig, refuses_to_open
from tests.support.daemon.rigs import names_of, texts_of


def begin(rig: LockstepRig, countdown_s: float = 0.0) -> None:
    rig.cycles(2)
    rig.post(OperatorAction.RESET)
    rig.commands.post(LoopCommand(OperatorAction.PROVE, countdown_s=countdown_s))
    rig.cycles(4)


def prove(rig: LockstepRig) -> None:
    begin(rig)
    rig.until(lambda: rig.mode is not Mode.PROVING, 5.0)


def test_arming_is_refused_until_every_output_is_proven(tmp_path: Path) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        with pytest.raises(DaemonError, match=r"rotary_valve safe state proven .*no valid value.*longreach prove"):
            rig.arm()
        pressure(devices, on=False)
        prove(rig)
        assert rig.mode is Mode.DISARMED
        assert texts_of(rig, "proven") == [f"{name} goes to its safe state by itself" for name in VALVES]
        assert all(rig.value(f"{name}.proven_s") > 0.0 for name in VALVES)
        pressure(devices, on=True)
        rig.arm()
        assert rig.mode is Mode.HOLDING


@pytest.mark.parametrize("value", [2e6, float("nan")])
def test_no_proof_under_pressure_or_without_knowing_it(tmp_path: Path, value: float) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        devices["hydraulic_unit"].override[PRESSURES[1]] = value
        prove(rig)
        assert rig.mode is Mode.DISARMED
        assert "proof" not in names_of(rig)


def test_no_proof_while_the_e_stop_is_latched(tmp_path: Path) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        rig.cycles(2)
        rig.post(OperatorAction.PROVE)
        rig.cycles(5)
        assert rig.mode is Mode.DISARMED
        assert "proof" not in names_of(rig)


def test_valves_are_opened_one_after_the_other_and_the_loop_keeps_time(tmp_path: Path) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        begin(rig)
        seen = []
        while rig.mode is Mode.PROVING:
            rig.cycles(1)
            seen.append(tuple(devices[name].is_open for name in VALVES))
        assert (True, True) not in seen
        assert sum(map(sum, seen)) == pytest.approx(4 * OPEN_CYCLES, abs=4)
        assert rig.value("overruns") == 0
    log = read_log(rig.recorder.finished[-1])
    assert set(np.diff(log.columns["cycle"])) == {1}
    assert log.metadata["recording"]["span"] == "proof"
    assert np.all(log.columns["rotary.command_V"] == 0.0)
    assert reexecute(log.path).identical


def test_the_proof_is_announced_every_second(tmp_path: Path) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        begin(rig, countdown_s=2.0)
        rig.cycles(1980)
        assert not any(devices[name].is_open for name in VALVES)
        rig.cycles(30)
        assert devices["rotary_valve"].is_open
        texts = texts_of(rig, "countdown")
        assert [text.partition(" move in ")[2] for text in texts] == [f"{left} s; the hydraulic pressure must be off" for left in (2, 1)]
        assert "rotary_valve and prismatic_valve move" in texts[0]


@pytest.mark.parametrize("end", ["pressure", "estop", "disarm", "stop", "leave", "raise"])
def test_whatever_ends_a_proof_early_leaves_safe_outputs_and_nothing_proven(tmp_path: Path, end: str) -> None:
    def cable_off() -> None:
        raise OSError("cable off")

    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        begin(rig)
        rig.cycles(OPEN_CYCLES // 2)
        assert devices["rotary_valve"].is_open
        match end:
            case "pressure":
                pressure(devices, on=True)
            case "raise":
                devices["rotary_valve"].on_prove = cable_off
            case "leave":
                rig.commands.post(LoopCommand(leave=True))
            case _:
                rig.post(OperatorAction[end.upper()])
        rig.cycles(2)
        assert rig.mode is (Mode.FAULT if end in ("pressure", "estop", "raise") else Mode.DISARMED)
        assert all(devices[name].verbs[-1] == "safe" for name in VALVES)
        assert not devices["rotary_valve"].is_open
        assert texts_of(rig, "not_proven")[0] == "rotary_valve: the proof was given up"
        assert all(np.isnan(rig.value(f"{name}.proven_s")) for name in VALVES)
        if end == "pressure":
            assert "supply_pressure off" in rig.loop.keeper.why_fault


@pytest.mark.parametrize(("late_s", "text"), [(0.12, "safe after 120.0 ms, limit 90 ms"), (None, "not safe within 90 ms")])
def test_one_valve_that_does_not_go_safe_keeps_the_rig_from_being_armed(tmp_path: Path, late_s: float | None, text: str) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        devices["prismatic_valve"].late_s = late_s
        prove(rig)
        assert text in texts_of(rig, "not_proven")[0]
        pressure(devices, on=True)
        with pytest.raises(DaemonError, match="prismatic_valve safe state proven"):
            rig.arm()
        assert rig.value("rotary_valve.proven_s") > 0.0


def test_a_later_proof_that_fails_takes_the_earlier_one_back(tmp_path: Path) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        prove(rig)
        assert rig.value("rotary_valve.proven_s") > 0.0
        refuses_to_open(devices["rotary_valve"])
        prove(rig)
        assert np.isnan(rig.value("rotary_valve.proven_s"))


def test_the_results_are_in_the_log_of_the_proof_and_in_every_later_one(tmp_path: Path) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        pressure(devices, on=False)
        prove(rig)
        pressure(devices, on=True)
        rig.arm()
        rig.disarm()
    of_proof, of_arming = (read_log(path) for path in rig.recorder.finished)
    proofs = [event for event in of_proof.events if event.name == "proof"]
    assert len(proofs) == 4
    assert all(event.values == {"ok": 1.0, "limit_s": 0.09, "time_to_safe_s": 0.06} for event in proofs)
    assert of_proof.attachments[ATTACHMENT] == of_arming.attachments[ATTACHMENT]
    content = json.loads(of_arming.attachments[ATTACHMENT])
    assert set(content) == set(VALVES)
    assert [result["name"] for result in content["rotary_valve"]["results"]] == [
        "rotary_valve: a missed heartbeat",
        "rotary_valve: missing set points",
    ]
    assert content["rotary_valve"]["proven_utc"].startswith("2000-01-01T")  # lockstep time
