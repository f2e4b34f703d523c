"""A driver of somebody else's that can prove its safe state: found by its entry point, proven, and demanded at arming."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from config.errors import DaemonError, DriverError
from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from config.options import driver_options, plug_ins
from config.options.plug_ins import DRIVERS
from config.schema.rig import Device, Rig
from daemon.lockstep import LockstepRig
from daemon.loop.command import LoopCommand
from daemon.modes.mode_machine import OperatorAction
from drivers.contract import Driver
from drivers.proof import ProofSteps, proof
from servo_control.signals import Mode
from tests.support.daemon.proving_rig import PRESSURES
from tests.support.daemon.simple_device import SimpleDevice

DEMANDED = "devices.plant.demand_proof=true"


class PlugIn(SimpleDevice):
    """One device with every channel, which goes safe `took_s` after we fall silent."""

    took_s = 0.05
    cannot_say = ""

    @property
    def needs_setup(self) -> bool:
        if self.cannot_say == "needs_setup":
            raise OSError("no answer")
        return False

    @property
    def setup_lost(self) -> str:
        if self.cannot_say == "setup_lost":
            raise OSError("no answer")
        return ""

    def prove_safe_state(self) -> ProofSteps:
        yield
        yield proof(f"{self.name}: outputs safe after silence", self.took_s, 0.08, "as told")


def create(name: str, device: Device, rig: Rig, lockstep: bool) -> Driver:
    return PlugIn(name, device, rig, lockstep)


def create_simple(name: str, device: Device, rig: Rig, lockstep: bool) -> Driver:
    return SimpleDevice(name, device, rig, lockstep)


@pytest.fixture(autouse=True)
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if a package with these entry points were installed."""
    factories = {"own": "create", "plain": "create_simple"}
    points = {name: EntryPoint(name, f"{__name__}:{factory}", DRIVERS) for name, factory in factories.items()}
    found = plug_ins.installed
    monkeypatch.setattr(driver_options, "installed", lambda group: found(group) | (points if group == DRIVERS else {}))


def plug_in_rig(*changes: str) -> LoadedRig:
    text = apply_overrides(load_rig("ornl_testbed").text, ["devices.plant.driver=own", *changes])
    return LoadedRig(rig_from_text(text), text, "plug_in.yaml")


def prove(rig: LockstepRig) -> None:
    gauges = rig.loop._devices._bank.drivers["plant"].override  # type: ignore[attr-defined]
    gauges.update(dict.fromkeys(PRESSURES, 0.0))
    rig.cycles(2)
    rig.post(OperatorAction.RESET)
    rig.commands.post(LoopCommand(OperatorAction.PROVE))
    rig.cycles(4)
    rig.until(lambda: rig.mode is not Mode.PROVING, 5.0)
    gauges.clear()


def test_a_plug_in_that_raises_when_its_proof_begins_is_a_fault_and_not_the_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def raises(self: PlugIn) -> ProofSteps:
        raise OSError("no supervision")

    with LockstepRig(plug_in_rig(DEMANDED), tmp_path) as rig:
        monkeypatch.setattr(PlugIn, "prove_safe_state", raises)
        prove(rig)
        assert rig.mode is Mode.FAULT
        assert "no supervision" in rig.loop.keeper.why_fault
        monkeypatch.undo()


def test_a_plug_in_that_cannot_say_what_it_lost_is_a_fault_and_not_the_end(tmp_path: Path) -> None:
    with LockstepRig(plug_in_rig(DEMANDED), tmp_path) as rig:
        prove(rig)
        rig.arm()
        plug_in = rig.loop._devices._bank.drivers["plant"]  # type: ignore[attr-defined]
        plug_in.cannot_say = "setup_lost"
        rig.cycles(2)
        assert rig.mode is Mode.FAULT
        plug_in.cannot_say = ""
        rig.post(OperatorAction.RESET)
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED


def test_a_plug_in_that_cannot_say_whether_it_is_set_up_is_set_up_by_a_reset(tmp_path: Path) -> None:
    with LockstepRig(plug_in_rig(DEMANDED), tmp_path) as rig:
        rig.cycles(2)
        plug_in = rig.loop._devices._bank.drivers["plant"]  # type: ignore[attr-defined]
        plug_in.cannot_say = "needs_setup"
        before = plug_in.verbs.count("configure")
        rig.post(OperatorAction.RESET)
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED
        assert plug_in.verbs.count("configure") == before + 1


def test_arming_demands_the_proof_of_a_plug_in(tmp_path: Path) -> None:
    with LockstepRig(plug_in_rig(DEMANDED), tmp_path) as rig:
        with pytest.raises(DaemonError, match=r"plant safe state proven \(plant\): no valid value.*longreach prove"):
            rig.arm()
        prove(rig)
        assert rig.value("plant.proven_s") > 0.0
        rig.arm()
        assert rig.mode is Mode.HOLDING


def test_a_plug_in_that_does_not_go_safe_in_time_is_not_armed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PlugIn, "took_s", 0.2)
    with LockstepRig(plug_in_rig(DEMANDED), tmp_path) as rig:
        prove(rig)
        assert np.isnan(rig.value("plant.proven_s"))
        with pytest.raises(DaemonError, match="plant safe state proven"):
            rig.arm()


def test_nothing_is_demanded_of_a_plug_in_by_default(tmp_path: Path) -> None:
    with LockstepRig(plug_in_rig(), tmp_path) as rig:
        rig.arm()
        assert rig.mode is Mode.HOLDING


def test_what_a_driver_cannot_prove_cannot_be_demanded(tmp_path: Path) -> None:
    loaded = plug_in_rig("devices.plant.driver=plain", DEMANDED)
    with pytest.raises(DriverError, match=r"devices\.plant\.demand_proof: the driver cannot prove .*: plain\. Remove demand_proof"):
        LockstepRig(loaded, tmp_path)
