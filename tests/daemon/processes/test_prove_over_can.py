"""The operator's proof of the safe state through the real drivers, against simulated devices, on the wall clock."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from daemon.checks.safe_state import ATTACHMENT
from daemon.modes.mode_machine import OperatorAction
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.support.daemon.can_daemon import CanDaemon, can_daemon
from tests.support.daemon.running_daemon import until

pytestmark = pytest.mark.clock


def prove(daemon: CanDaemon) -> None:
    daemon.post(OperatorAction.RESET)
    daemon.pressure(on=False)
    daemon.post(OperatorAction.PROVE)
    until(lambda: daemon.mode is Mode.PROVING, 5.0)
    until(lambda: daemon.mode is not Mode.PROVING, 20.0)


@pytest.mark.device_clock
def test_prove_then_arm(tmp_path: Path) -> None:
    """A valve and an output module on one bus: each falls silent twice, all are in order afterwards, and the rig can be armed."""
    with can_daemon(tmp_path) as daemon:
        daemon.post(OperatorAction.RESET)
        daemon.post(OperatorAction.ARM)
        until(lambda: daemon.value("commands") == 2)
        until(lambda: daemon.value("rotary.supply_pressure_Pa") > 12e6, 20.0)
        assert daemon.mode is Mode.DISARMED, "not proven yet"
        prove(daemon)
        assert daemon.mode is Mode.DISARMED, daemon.texts("fault")
        assert not daemon.texts("not_proven")
        assert len(daemon.texts("proof")) == 4
        took_s = [event.values["time_to_safe_s"] for event in daemon.events if event.name == "proof"]
        assert all(0.15 < seconds < 0.23 for seconds in took_s), took_s  # their time-out is 200 ms, our heartbeat comes every 67 ms
        daemon.pressure(on=True)
        until(lambda: not any(check.name for check in daemon.loop.keeper.checks if not check.passes(daemon.loop.values)), 10.0)
        daemon.post(OperatorAction.ARM)
        until(lambda: daemon.mode is Mode.HOLDING, 5.0)
        daemon.post(OperatorAction.DISARM)
        until(lambda: daemon.mode is Mode.DISARMED, 5.0)
        until(lambda: len(daemon.recorder.finished) == 2, 5.0)
    proof, armed = (read_log(path) for path in daemon.recorder.finished[:2])
    assert set(np.diff(proof.columns["cycle"])) == {1}
    assert proof.columns["mode"].max() == Mode.PROVING
    assert set(json.loads(armed.attachments[ATTACHMENT])) == {"rotary_valve", "io"}


@pytest.mark.device_clock
def test_a_valve_set_to_ignore_us_is_found_out(tmp_path: Path) -> None:
    """Its fault reaction is 0: it would stay open when this computer dies."""
    with can_daemon(tmp_path, ["devices.rotary_valve.options.fault_reactions={36: 0, 41: 3}"]) as daemon:
        prove(daemon)
        assert "spool safe after a missed heartbeat: not safe within 230 ms (state ACTIVE, spool 10.0 %)" in daemon.texts("not_proven")[0]
        assert np.isnan(daemon.value("rotary_valve.proven_s"))
        assert daemon.value("io.proven_s") > 0.0
        daemon.pressure(on=True)
        daemon.post(OperatorAction.ARM)
        until(lambda: daemon.value("commands") >= 3)
        assert daemon.mode is Mode.DISARMED
