"""One of several devices raises: every other one is still read, made safe and closed."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite, isnan
from pathlib import Path

import pytest

from config.errors import DriverError
from daemon.checks.interlocks import rig_facts
from daemon.lockstep import LockstepRig
from daemon.loop.command import LoopCommand
from daemon.loop.device_bank import DeviceBank
from daemon.modes.mode_machine import OperatorAction
from drivers.contract import Quality
from recording.files.reader import read_log
from recording.format.fields import field_of_signal
from servo_control.signals import Mode
from tests.support.daemon.proving_rig import RIG, pressure, proving_rig
from tests.support.daemon.rigs import JOG, MS
from tests.support.daemon.simple_device import SimpleDevice, factory

DEVICES = tuple(RIG.rig.devices)


def cable_off() -> None:
    raise OSError("cable off")


def once(action: Callable[[], None]) -> Callable[[], None]:
    """`action` in the first call, nothing in those that follow."""
    left = [action]
    return lambda: left.pop()() if left else None


def arm(rig: LockstepRig, devices: dict[str, SimpleDevice]) -> None:
    """Proven first, which needs the pressure off."""
    pressure(devices, on=False)
    rig.cycles(2)
    rig.post(OperatorAction.RESET)
    rig.commands.post(LoopCommand(OperatorAction.PROVE))
    rig.cycles(4)
    rig.until(lambda: rig.mode is not Mode.PROVING, 5.0)
    pressure(devices, on=True)
    rig.arm()


def bring_to(mode: Mode, rig: LockstepRig, devices: dict[str, SimpleDevice]) -> None:
    arm(rig, devices)
    if mode is Mode.RUNNING:
        rig.start(JOG)
        rig.until(lambda: rig.mode is Mode.RUNNING, 0.1)  # not for long: these encoders do not follow the valves
    assert rig.mode is mode
    for device in devices.values():
        device.verbs.clear()


@pytest.mark.parametrize("mode", [Mode.HOLDING, Mode.RUNNING])
@pytest.mark.parametrize("broken", DEVICES)
def test_an_e_stop_makes_every_other_device_safe(tmp_path: Path, broken: str, mode: Mode) -> None:
    with proving_rig(tmp_path) as (rig, devices):
        bring_to(mode, rig, devices)
        devices[broken].on_safe = cable_off
        rig.post(OperatorAction.ESTOP)
        rig.cycles(2)
        others = [device for name, device in devices.items() if name != broken]
        assert [device.verbs for device in others] == [["safe"]] * len(others)
        assert [device.written for device in others] == [None] * len(others)
        assert rig.mode is Mode.FAULT
        devices[broken].on_safe = lambda: None


@pytest.mark.parametrize("broken", DEVICES)
def test_what_a_device_that_cannot_be_read_measures_is_unknown_and_every_other_one_is_read(broken: str) -> None:
    made: list[SimpleDevice] = []
    facts = rig_facts(RIG.rig)
    values = facts.blank()
    bank = DeviceBank(RIG.rig, facts, lockstep=True, create=factory(made))
    bank.open()
    bank.read(MS, values)
    for device in made:
        device.age_ns = dict.fromkeys(RIG.rig.signals, MS)  # what is read anew says so by its age
        device.on_read = cable_off if device.name == broken else lambda: None
    with pytest.raises(DriverError, match=f"devices.{broken}: OSError: cable off"):
        bank.read(2 * MS, values)
    for name, signal in RIG.rig.signals.items():
        value, raw = values[facts.index(field_of_signal(name))], values[facts.index(f"{name}_raw")]
        quality, age_s = values[facts.index(f"{name}.quality")], values[facts.index(f"{name}_age_s")]
        if signal.device == broken:
            assert isnan(value)
            assert isnan(raw)
            assert quality == Quality.BAD
        else:
            assert isfinite(value)
            assert (quality, age_s) == (Quality.GOOD, pytest.approx(1e-3))


def test_when_one_device_does_not_open_those_before_it_are_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[SimpleDevice] = []
    bank = DeviceBank(RIG.rig, rig_facts(RIG.rig), lockstep=True, create=factory(made))
    monkeypatch.setattr(made[1], "open", cable_off)
    with pytest.raises(DriverError, match=f"devices.{made[1].name}: the device did not open: OSError: cable off"):
        bank.open()
    assert made[0].verbs == ["open", "configure", "safe", "close"]
    assert all("open" not in device.verbs for device in made[1:])


@pytest.mark.parametrize("broken", DEVICES)
def test_the_loop_ends_with_its_recording_and_every_device_closed_although_one_cannot_be_made_safe(tmp_path: Path, broken: str) -> None:
    with pytest.raises(DriverError, match=f"devices.{broken}: OSError: cable off"), proving_rig(tmp_path) as (rig, devices):  # noqa: PT012
        bring_to(Mode.HOLDING, rig, devices)
        devices[broken].on_safe = once(cable_off)
    assert read_log(rig.recorder.finished[-1]).metadata["closing"]["ended_by"] == "the loop ended"
    assert all(device.verbs[-1] == "close" for device in devices.values())
    assert all(device.written is None for device in devices.values())
