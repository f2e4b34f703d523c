"""The announcement of motion, and what takes it back."""

from __future__ import annotations

from math import nan
from pathlib import Path

from daemon.modes.mode_machine import OperatorAction
from daemon.modes.run_watch import RunVerdict
from servo_control.signals import Mode
from tests.support.daemon.rigs import JOG, names_of, simple_rig, texts_of


def test_motion_is_announced_every_second_and_a_stop_takes_it_back(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, _):
        rig.arm()
        rig.start({**JOG, "countdown_s": 3.0})
        rig.cycles(2500)
        assert rig.mode is Mode.HOLDING
        assert texts_of(rig, "countdown") == [f"run 1: motion of rotary starts in {left} s" for left in (3, 2, 1)]
        rig.post(OperatorAction.STOP)
        rig.cycles(1000)
        assert rig.mode is Mode.HOLDING
        assert "run_started" not in names_of(rig)
        assert texts_of(rig, "run_ended") == ["run 1: invalid, because stop was asked for before it began"]


def test_a_run_is_not_started_while_a_stop_condition_holds(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start({**JOG, "countdown_s": 1.0})
        rig.cycles(500)
        device.override["reservoir_temperature"] = 66.0
        rig.cycles(700)
        assert rig.mode is Mode.HOLDING
        assert "reservoir_temperature limit" in texts_of(rig, "run_ended")[0]


def test_a_fault_during_the_countdown_ends_the_run(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start({**JOG, "countdown_s": 1.0})
        rig.cycles(100)
        device.override["rotary.position"] = nan
        rig.cycles(2)
        assert rig.loop.keeper.run.verdict is RunVerdict.INVALID
        assert "rotary.position quality" in rig.loop.keeper.run.reason
