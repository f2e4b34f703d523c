"""How the arm is armed and stopped: nothing acts before arming, and every way of stopping ends where it says."""

from __future__ import annotations

from pathlib import Path

import pytest
from rigs import JOG, MS, delay_once, simple_rig

from config.errors import DaemonError
from control.signals import Mode
from daemon.command import Command
from daemon.modes import Event
from recording.reader import read_log


def test_starts_disarmed_with_the_e_stop_latched(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.cycles(5)
        assert rig.mode is Mode.DISARMED
        rig.post(Event.ARM)
        rig.cycles(5)
        assert rig.mode is Mode.DISARMED
        assert "activate" not in device.verbs
        rig.post(Event.RESET)
        rig.post(Event.ARM)
        rig.cycles(5)
        assert rig.mode is Mode.ARMING
        assert device.verbs[-1] == "activate"


def test_nothing_is_written_before_arming_and_zero_while_arming(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.cycles(20)
        assert device.written is None
        rig.post(Event.RESET)
        rig.post(Event.ARM)
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
        rig.post(Event.ESTOP)
        rig.cycles(2)
        assert rig.mode is Mode.FAULT
        assert device.written is None
        with pytest.raises(DaemonError):
            rig.until(lambda: rig.mode is not Mode.FAULT, 0.5)


def test_stop_decelerates_and_holds_and_the_run_is_invalid(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        rig.post(Event.STOP)
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
        rig.post(Event.STOP)
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
        rig.commands.post(Command(leave=True))
        rig.until(lambda: rig.loop.left, 3.0)
        assert rig.mode is Mode.DISARMED
        modes = read_log(rig.recorder.finished[-1]).columns["mode"]
        assert {int(mode) for mode in modes[-100:]} >= {int(Mode.STOPPING), int(Mode.DISARMED)} or Mode.STOPPING in modes
        assert device.written is None
        assert rig.loop.keeper.run.reason == "the daemon ends"


def test_leaving_twice_is_safe_at_once(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        rig.commands.post(Command(leave=True))
        rig.commands.post(Command(Event.DISARM, leave=True))
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED
        assert rig.loop.left
        assert device.written is None
