"""The shipped rig with a ±10 V valve on an analogue module: it passes check, and moves in lockstep and over the twin."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np
import pytest

from config.checking.check import check_rig
from config.loading.load import load_rig
from config.loading.stand_in import with_simulated_devices
from daemon.lockstep import run_lockstep
from daemon.modes.mode_machine import OperatorAction
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.support.daemon.can_daemon import can_daemon
from tests.support.daemon.running_daemon import until

STALLS = [  # of the machine are not what is tested here
    "devices.encoder.options.missing_frames=100",
    "devices.valve_module.options.missing_frames=100",
    "devices.valve_module.options.failed_cycles=100",
    "devices.valve_module.timeout=1 s",
    "signals.axis.supply_pressure.max_age=1 s",
]
JOG = {"maneuver": {"name": "jog"}, "parameters": ["joint=axis", "by=20 mm", "speed=20 mm/s"]}


def rig_text(channel: str, port: int) -> str:
    text = load_rig("analogue_axis").text
    text = text.replace("interface: socketcan, channel: can0", f"interface: virtual, channel: {channel}")
    return text.replace("port: 1502", f"port: {port}")


def test_check_has_nothing_against_it() -> None:
    assert [each.text for each in check_rig(load_rig("analogue_axis"), datetime.date(2026, 1, 1)) if each.level != "ok"] == []


def test_it_moves_in_lockstep(tmp_path: Path) -> None:
    (path,) = run_lockstep(with_simulated_devices(load_rig("analogue_axis")), [JOG], tmp_path)
    position = read_log(path).columns["axis.position"]
    np.testing.assert_allclose(position[-1] - position[0], 0.020, atol=0.5e-3)


@pytest.mark.clock
@pytest.mark.device_clock
def test_it_is_proven_armed_and_moved_over_the_twin(tmp_path: Path) -> None:
    with can_daemon(tmp_path, STALLS, rig_text) as daemon:
        daemon.post(OperatorAction.RESET)
        daemon.pressure(on=False)
        daemon.post(OperatorAction.PROVE)
        until(lambda: daemon.mode is Mode.PROVING, 5.0)
        until(lambda: daemon.mode is not Mode.PROVING, 20.0)
        assert len(daemon.texts("proof")) == 2, daemon.texts("mode") + daemon.texts("fault") + daemon.texts("not_proven")
        daemon.pressure(on=True)
        until(lambda: not any(check.name for check in daemon.loop.keeper.checks if not check.passes(daemon.loop.values)), 20.0)
        daemon.post(OperatorAction.ARM)
        until(lambda: daemon.mode is Mode.HOLDING, 5.0)
        began = daemon.twin.bench.feed.plant.true_position[0]
        daemon.start(JOG)
        until(lambda: daemon.mode is Mode.RUNNING, 5.0)
        until(lambda: daemon.mode is not Mode.RUNNING, 30.0)
        assert daemon.mode is Mode.HOLDING, daemon.texts("fault")
        np.testing.assert_allclose(daemon.twin.bench.feed.plant.true_position[0] - began, 0.020, atol=1e-3)
