"""How the arm is armed and stopped: nothing acts before arming, and every way of stopping ends where it says."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

import pytest

from config.errors import DaemonError
from daemon.loop.command import LoopCommand
from daemon.modes.mode_machine import OperatorAction
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.support.daemon.rigs import JOG, MS, delay_once, simple_rig


def test_starts_disarmed_with_the_e_stop_latched(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.cycles(5)
        assert rig.mode is Mode.DISARMED
        rig.post(OperatorAction.ARM)
        rig.cycles(5)
        assert rig.mode is Mode.DISARMED
        assert "activate" not in device.verbs
        rig.post(OperatorAction.RESET)
        rig.post(OperatorAction.ARM)
        rig.cycles(5)
        assert rig.mode is Mode.ARMING
        assert device.verbs[-1] == "activate"


def test_nothing_is_written_before_arming_and_zero_while_arming(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.cycles(20)
        assert device.written is None
        rig.post(OperatorAction.RESET)
        rig.post(OperatorAction.ARM)
        rig.until(lambda: rig.mode is Mode.ARMING)
        for _ in range(100):
            rig.cycles(1)
            assert rig.mode is Mode.ARMING
            assert device.written == [0.0, 0.0]


def test_devices_may_take_their_time_to_become_active(tmp_path: Path) -> None:
    """A CANopen valve goes through its states meanwhile; longer than the stall limit, but nothing acts yet."""
    with simple_rig(tmp_path) as (rig, device):
        device.on_activate = lambda: delay_once(rig, 120 * MS)
        rig.arm()
        assert rig.mode is Mode.HOLDING
        assert rig.value("overruns") == 0


def test_e_stop_while_running_is_safe_in_the_next_cycle_and_latched(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(300)
        rig.post(OperatorAction.ESTOP)
        rig.cycles(2)
        assert rig.mode is Mode.FAULT
        assert device.written is None
        with pytest.raises(DaemonError):
            rig.until(lambda: rig.mode is not Mode.FAULT, 0.5)


@pytest.mark.parametrize("asked", [False, True], ids=["a run", "a stop under way"])
def test_a_lost_recorder_ends_in_a_fault_though_it_comes_back_before_rest(tmp_path: Path, asked: bool) -> None:
    """IEC 60204-1, stop category 1: once begun, the stop ends with the outputs safe."""
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        if asked:
            rig.post(OperatorAction.STOP)
            rig.cycles(3)
        failed = rig.facts.index("recorder.failed")
        rig.loop.values[failed] = 1.0
        rig.cycles(2)
        assert rig.mode is Mode.STOPPING
        rig.loop.values[failed] = 0.0
        rig.cycles(2)
        assert rig.mode is Mode.STOPPING
        rig.until(lambda: rig.mode is not Mode.STOPPING, 2.0)
        rig.cycles(2)
        assert rig.mode is Mode.FAULT
        assert device.written is None
        assert rig.loop.keeper.why_fault.startswith("recorder lost (recorder): 1 (limit 0)")
        rig.post(OperatorAction.RESET)
        rig.arm()  # and it is forgotten with the reset
        rig.start(JOG)
        rig.until(lambda: not rig.loop.keeper.run.active, 20.0)
        assert rig.mode is Mode.HOLDING
        assert rig.loop.keeper.run.reason == ""


def test_stop_decelerates_and_holds_and_the_run_is_invalid(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        rig.post(OperatorAction.STOP)
        rig.cycles(2)
        assert rig.mode is Mode.STOPPING
        rig.until(lambda: rig.mode is Mode.HOLDING, 2.0)
        assert device.written is not None
        assert rig.loop.keeper.run.reason == "stop was asked for"
        before = rig.value("rotary.reference")
        rig.cycles(200)
        assert rig.value("rotary.reference") == before


def test_a_stop_that_takes_too_long_is_a_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with simple_rig(tmp_path) as (rig, _):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        compute = rig.loop._compute

        def never_at_rest() -> None:
            compute()
            rig.loop.keeper.conditions.at_rest = False

        monkeypatch.setattr(rig.loop, "_compute", never_at_rest)
        rig.post(OperatorAction.STOP)
        rig.until(lambda: rig.mode is Mode.FAULT, 6.0)
        assert "longer than 5 s" in rig.loop.keeper.why_fault


def test_disarm_while_running_is_safe_at_once(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(300)
        rig.disarm()
        assert rig.mode is Mode.DISARMED
        assert device.written is None


def test_leaving_stops_the_run_disarms_and_ends(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        rig.commands.post(LoopCommand(leave=True))
        rig.until(lambda: rig.loop.left, 3.0)
        assert rig.mode is Mode.DISARMED
        modes = read_log(rig.recorder.finished[-1]).columns["mode"].tolist()
        assert [mode for mode, _ in groupby(modes)] == [Mode.ARMING, Mode.HOLDING, Mode.RUNNING, Mode.STOPPING, Mode.HOLDING, Mode.DISARMED]
        assert device.written is None
        assert rig.loop.keeper.run.reason == "the daemon ends"


def test_leaving_twice_is_safe_at_once(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        rig.commands.post(LoopCommand(leave=True))
        rig.commands.post(LoopCommand(OperatorAction.DISARM, leave=True))
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED
        assert rig.loop.left
        assert device.written is None
