"""Cycles that end late: counted with their culprit, a controlled stop when there are many, a fault when one stands still."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from daemon.modes.run_watch import RunVerdict
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.support.daemon.rigs import JOG, MS, delay_once, simple_rig, texts_of


def test_overrun_of_5_ms_is_counted_with_its_culprit_and_does_not_spoil_the_run(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(100)
        device.on_write = lambda: delay_once(rig, 5 * MS)
        rig.cycles(1)
        device.on_write = lambda: None
        rig.until(lambda: not rig.loop.keeper.run.active, 3.0)
        assert rig.loop.keeper.run.verdict is RunVerdict.VALID
        assert rig.value("overruns") == 1
        assert "slowest: write" in texts_of(rig, "overrun")[0]
        rig.disarm()
        log = read_log(rig.recorder.finished[-1])
        assert np.diff(log.columns["t_s"]).max() == pytest.approx(5e-3), "the skipped periods show as a gap in t_s"
        assert set(np.diff(log.columns["cycle"])) == {1}
        assert log.metadata["closing"]["overrun_culprits"] == "write 1"
        assert log.metadata["closing"]["missed_periods"] == "4"


def test_repeated_overruns_of_5_ms_are_a_controlled_stop(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(100)
        device.on_read = lambda: delay_once(rig, 5 * MS)
        rig.cycles(21)
        assert rig.mode is Mode.STOPPING
        device.on_read = lambda: None
        rig.until(lambda: rig.mode is Mode.HOLDING, 3.0)
        assert "loop timing" in rig.loop.keeper.run.reason


def test_many_missed_periods_spoil_a_run_that_was_not_stopped(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(100)
        device.on_read = lambda: delay_once(rig, 5 * MS)
        rig.cycles(15)
        device.on_read = lambda: None
        rig.until(lambda: not rig.loop.keeper.run.active, 3.0)
        assert "periods were missed" in rig.loop.keeper.run.reason


def test_a_stall_of_100_ms_is_a_fault(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.on_read = lambda: delay_once(rig, 100 * MS)
        rig.cycles(1)
        device.on_read = lambda: None
        rig.cycles(1)
        assert rig.mode is Mode.FAULT
        assert "loop stall" in rig.loop.keeper.why_fault
        assert device.written is None
