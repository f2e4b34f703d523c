"""A device that restarts: safe outputs, a fault that says what to do, its proof void; a reset sets it up again and the service goes on."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from config.errors import DaemonError, DriverError
from config.schema.rig import Device, Rig
from daemon.lockstep import LockstepRig
from daemon.loop.command import LoopCommand
from daemon.modes.mode_machine import OperatorAction
from drivers.contract import KeepsSetup, Sample
from servo_control.signals import Mode
from tests.support.daemon.can_daemon import CanDaemon, can_daemon
from tests.support.daemon.lockstep_requests import LockstepRequests, at_once
from tests.support.daemon.proving_rig import VALVES, ProvingValve, pressure, proving_rig
from tests.support.daemon.rigs import JOG, texts_of
from tests.support.daemon.running_daemon import until

VALVE = "rotary_valve"


class ForgetfulValve(ProvingValve):
    """`forget()` is a restart; `refuses` settings when set."""

    def __init__(self, name: str, device: Device, rig: Rig, lockstep: bool) -> None:
        super().__init__(name, device, rig, lockstep)
        self.setup_lost = ""
        self.needs_setup = False
        self.refuses = ""

    def forget(self) -> None:
        self.setup_lost, self.needs_setup = "restarted by itself", True

    def configure(self) -> None:
        super().configure()
        if self.refuses:
            raise DriverError(self.refuses)
        self.setup_lost, self.needs_setup = "", False

    def read(self, now_ns: int) -> Sequence[Sample]:
        samples = super().read(now_ns)
        if self.setup_lost:
            raise DriverError(f"{self.name}: the device {self.setup_lost}")
        return samples


@pytest.fixture(autouse=True)
def forgetful(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.support.daemon.proving_rig.ProvingValve", ForgetfulValve)


def prove(rig: LockstepRig, devices: dict[str, ForgetfulValve]) -> None:
    pressure(devices, on=False)  # type: ignore[arg-type]
    rig.cycles(2)
    rig.post(OperatorAction.RESET)
    rig.commands.post(LoopCommand(OperatorAction.PROVE))
    rig.cycles(4)
    rig.until(lambda: rig.mode is not Mode.PROVING, 5.0)
    pressure(devices, on=True)  # type: ignore[arg-type]


def bring_to(rig: LockstepRig, devices: dict[str, ForgetfulValve], mode: Mode) -> None:
    """Proven, and then in `mode`."""
    prove(rig, devices)
    assert rig.value(f"{VALVE}.proven_s") > 0.0
    if mode is Mode.DISARMED:
        return
    if mode is Mode.PROVING:
        pressure(devices, on=False)  # type: ignore[arg-type]
        rig.cycles(2)
        rig.commands.post(LoopCommand(OperatorAction.PROVE))
        rig.cycles(5)
    elif mode is Mode.FAULT:
        rig.post(OperatorAction.ESTOP)
        rig.cycles(3)
    elif mode is Mode.ARMING:
        rig.cycles(2)
        rig.post(OperatorAction.ARM)
        rig.cycles(3)
    else:
        rig.arm()
        if mode is not Mode.HOLDING:
            rig.start(JOG)
            rig.until(lambda: rig.mode is Mode.RUNNING)
            rig.cycles(150)
        if mode is Mode.STOPPING:
            rig.post(OperatorAction.STOP)
            rig.cycles(3)
    assert rig.mode is mode


@pytest.mark.parametrize("mode", list(Mode))
def test_a_restart_in_any_mode_is_a_fault_with_safe_outputs_and_voids_the_proof(tmp_path: Path, mode: Mode) -> None:
    with proving_rig(tmp_path) as (rig, made):
        devices: dict[str, ForgetfulValve] = made  # type: ignore[assignment]
        assert isinstance(devices[VALVE], KeepsSetup)
        bring_to(rig, devices, mode)
        devices[VALVE].forget()
        rig.cycles(1)
        assert rig.mode is Mode.FAULT
        assert all(devices[name].written is None and not devices[name].is_open for name in VALVES)
        assert np.isnan(rig.value(f"{VALVE}.proven_s"))
        if mode is not Mode.PROVING:  # where it had begun anew
            assert rig.value("prismatic_valve.proven_s") > 0.0, "the other one goes on as it was"
            assert "rotary_valve: the proof of its safe state no longer counts" in texts_of(rig, "proof_void")[0]
        if mode is not Mode.FAULT:
            assert "rotary_valve: the device restarted by itself" in texts_of(rig, "fault")[-1]

        configured = devices[VALVE].verbs.count("configure")
        rig.post(OperatorAction.RESET)
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED
        assert devices[VALVE].verbs.count("configure") == configured + 1
        pressure(devices, on=True)  # type: ignore[arg-type]
        with pytest.raises(DaemonError, match=r"rotary_valve safe state proven.*longreach prove"):
            rig.arm()
        prove(rig, devices)
        rig.arm()
        assert rig.mode is Mode.HOLDING
        assert rig.value("overruns") == 0


def test_a_device_that_does_not_take_its_settings_keeps_the_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("daemon.server.request_handlers.asyncio.sleep", at_once)
    with proving_rig(tmp_path) as (rig, made):
        valve: ForgetfulValve = made[VALVE]  # type: ignore[assignment]
        prove(rig, made)  # type: ignore[arg-type]
        lockstep = LockstepRequests(rig)
        lockstep._posted = int(rig.value("commands"))
        valve.forget()
        rig.cycles(2)
        valve.refuses = "node 11: object 0x6443 does not hold what it must"
        with pytest.raises(DaemonError, match=r"reset refused: fault \(limit: every device set up\).*0x6443 does not hold what it must"):
            asyncio.run(lockstep.handlers.reset({}))
        assert rig.mode is Mode.FAULT
        valve.refuses = ""
        assert asyncio.run(lockstep.handlers.reset({})) == {"mode": "disarmed"}


def test_a_reset_without_a_restart_sets_nothing_up(tmp_path: Path) -> None:
    with proving_rig(tmp_path) as (rig, made):
        prove(rig, made)  # type: ignore[arg-type]
        rig.post(OperatorAction.ESTOP)
        rig.cycles(3)
        rig.post(OperatorAction.RESET)
        rig.cycles(3)
        assert made[VALVE].verbs.count("configure") == 1
        assert rig.value(f"{VALVE}.proven_s") > 0.0


def set_up_again(daemon: CanDaemon) -> None:
    """A reset, as the operator asks for it."""
    told = len(daemon.texts("set_up"))
    daemon.post(OperatorAction.RESET)
    until(lambda: len(daemon.texts("set_up")) > told or bool(daemon.texts("not_set_up")), 30.0)
    assert not daemon.texts("not_set_up")
    until(lambda: daemon.mode is Mode.DISARMED, 5.0)


def proven(daemon: CanDaemon) -> None:
    """A machine that stands still in a proof makes it fail: then once more."""
    daemon.pressure(on=False)
    for _ in range(3):
        with suppress(AssertionError):
            if daemon.mode is Mode.FAULT:
                daemon.post(OperatorAction.RESET)
                until(lambda: daemon.mode is Mode.DISARMED, 30.0)
            daemon.post(OperatorAction.PROVE)
            until(lambda: daemon.mode is Mode.PROVING, 5.0)
            until(lambda: daemon.mode is not Mode.PROVING, 20.0)
        if all(daemon.value(f"{name}.proven_s") > 0.0 for name in (VALVE, "io")):
            break
    daemon.pressure(on=True)
    until(lambda: all(check.passes(daemon.loop.values) for check in daemon.loop.keeper.checks), 20.0)


def restart_and_reset(daemon: CanDaemon) -> None:
    """The valve boots: safe outputs, a fault, no proof; then an operator's reset."""
    faults = len(daemon.texts("fault"))
    daemon.control.inject(VALVE, "restart", 0.0)
    until(lambda: daemon.mode is Mode.FAULT and len(daemon.texts("fault")) > faults, 10.0)
    assert "rotary_valve: node 5: the device restarted by itself and has lost its settings" in daemon.texts("fault")[-1]
    assert "`longreach reset` sets it up again" in daemon.texts("fault")[-1]
    until(lambda: "safe_since_ns" in daemon.control.describe()[VALVE], 5.0)
    until(lambda: bool(np.isnan(daemon.value(f"{VALVE}.proven_s"))), 5.0)
    set_up_again(daemon)
    assert daemon.control.describe()[VALVE]["nmt"] == "operational"
    assert np.isnan(daemon.value(f"{VALVE}.proven_s")), "set up is not proven"


@pytest.mark.slow
@pytest.mark.device_clock
def test_a_valve_of_the_twin_restarts_disarmed_and_armed_and_moving(tmp_path: Path) -> None:
    """The real driver and a simulated node that loses every setting: it is set up, read back and proven again, in one service."""
    with can_daemon(tmp_path) as daemon:
        daemon.post(OperatorAction.RESET)
        until(lambda: daemon.mode is Mode.DISARMED, 5.0)
        for mode in (Mode.DISARMED, Mode.HOLDING, Mode.RUNNING):
            proven(daemon)
            if mode is not Mode.DISARMED:
                daemon.post(OperatorAction.ARM)
                until(lambda: daemon.mode is Mode.HOLDING, 10.0)
            if mode is Mode.RUNNING:
                daemon.start(JOG)
                until(lambda: daemon.mode is Mode.RUNNING, 10.0)
            restart_and_reset(daemon)
        proven(daemon)
        assert daemon.value("io.proven_s") > 0.0
