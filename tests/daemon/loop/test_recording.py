"""The loop and its recorder: without one the arm stops, and every arming has a recording that re-executes."""

from __future__ import annotations

from math import nan
from pathlib import Path

import numpy as np
import pytest

from recording.evaluation.replay import reexecute
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.support.daemon.rigs import JOG, simple_rig


def test_a_lost_recorder_is_a_controlled_stop_and_then_a_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        update = rig.loop._health.update

        def lost(values: list[float], now_ns: int) -> None:
            update(values, now_ns)
            values[rig.facts.index("recorder.failed")] = 1.0

        monkeypatch.setattr(rig.loop._health, "update", lost)
        rig.cycles(1)
        assert rig.mode is Mode.STOPPING
        assert device.written is not None, "outputs act until the arm has come to rest"
        rig.until(lambda: rig.mode is Mode.FAULT, 3.0)
        assert "recorder lost" in rig.loop.keeper.why_fault
        assert device.written is None


def test_dropped_records_stop_the_run(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, _):
        rig.arm()
        rig.start(JOG)
        rig.cycles(300)
        rig.loop._log._recorder.dropped = 3  # type: ignore[misc]
        rig.until(lambda: rig.mode is Mode.FAULT, 3.0)
        assert "records dropped" in rig.loop.keeper.run.reason


def test_every_arming_has_a_recording_of_its_own_that_re_executes(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        for _ in range(3):
            rig.one_run(JOG)
        rig.arm()
        rig.start({"maneuver": {"name": "paper_line"}, "shaper": {"kind": "adaptive"}, "approach": True})
        rig.cycles(3000)
        device.override["rotary.position"] = nan
        rig.cycles(2100)
    assert len(rig.recorder.finished) == 4
    for path in rig.recorder.finished:
        result = reexecute(path)
        assert result.identical, result.text()
    log = read_log(rig.recorder.finished[-1])
    assert log.metadata["closing"]["ended_by"] == "fault"
    assert np.isnan(log.columns["rotary.position"][-1])
    assert log.columns["mode"][-1] == Mode.FAULT
    assert np.sum(log.columns["mode"] == Mode.FAULT) == pytest.approx(2000, abs=2)
