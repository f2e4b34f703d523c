"""Devices that raise, and a mistake of our own: outputs are safe, and the loop goes on or ends in order."""

from __future__ import annotations

from pathlib import Path

import pytest

from daemon.modes.mode_machine import OperatorAction
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.support.daemon.rigs import simple_rig, texts_of


@pytest.mark.parametrize("verb", ["read", "write"])
def test_a_device_that_raises_is_a_fault_and_not_the_end(tmp_path: Path, verb: str) -> None:
    def cable_off() -> None:
        raise OSError("cable off")

    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        setattr(device, f"on_{verb}", cable_off)
        rig.cycles(2)
        assert rig.mode is Mode.FAULT
        assert device.written is None
        assert "cable off" in rig.loop.keeper.why_fault
        setattr(device, f"on_{verb}", lambda: None)
        rig.post(OperatorAction.RESET)
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED
        rig.arm()
        assert rig.mode is Mode.HOLDING


@pytest.mark.parametrize("verb", ["read", "write", "activate"])
def test_a_device_cannot_end_the_process(tmp_path: Path, verb: str) -> None:
    """A library below a driver may call sys.exit()."""

    def end() -> None:
        raise SystemExit(0)

    with simple_rig(tmp_path) as (rig, device):
        rig.cycles(2)
        setattr(device, f"on_{verb}", end)
        rig.post(OperatorAction.RESET)
        rig.post(OperatorAction.ARM)
        rig.until(lambda: rig.mode is Mode.FAULT, 1.0)
        assert device.written is None
        assert "devices.plant: SystemExit" in rig.loop.keeper.why_fault


def test_outputs_are_made_safe_on_all_devices_when_one_refuses_to_activate(tmp_path: Path) -> None:
    """Those before it are active already, and an active valve that is not told stays where it is."""

    def not_ready() -> None:
        raise OSError("valve not ready")

    with simple_rig(tmp_path) as (rig, device):
        rig.cycles(2)
        device.on_activate = not_ready
        rig.post(OperatorAction.RESET)
        rig.post(OperatorAction.ARM)
        rig.until(lambda: rig.mode is Mode.FAULT, 1.0)
        assert device.verbs[-2:] == ["activate", "safe"]
        assert "valve not ready" in rig.loop.keeper.why_fault
        device.on_activate = lambda: None
        rig.post(OperatorAction.RESET)
        rig.cycles(3)
        rig.arm()
        assert rig.mode is Mode.HOLDING


def test_a_device_that_stays_dead_is_told_once_and_not_a_thousand_times_a_second(tmp_path: Path) -> None:
    def cable_off() -> None:
        raise OSError("cable off")

    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.on_read = device.on_safe = cable_off
        rig.cycles(1000)
        assert rig.mode is Mode.FAULT
        assert len(texts_of(rig, "fault")) == 1
        assert len(texts_of(rig, "device")) == 1
        device.on_read = device.on_safe = lambda: None
        rig.post(OperatorAction.RESET)
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED


def test_an_exception_in_the_loop_itself_leaves_safe_outputs_and_a_closed_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.cycles(10)

        def broken() -> None:
            raise RuntimeError("a mistake of ours")

        monkeypatch.setattr(rig.loop, "_compute", broken)
        with pytest.raises(RuntimeError):
            rig.loop.run()
        assert device.written is None
        assert device.verbs[-1] == "close"
        assert read_log(rig.recorder.finished[-1]).metadata["closing"]["ended_by"] == "the loop ended"
        monkeypatch.undo()
