"""Every cycle is in a log, also while disarmed; standby recordings are bounded, recordings of an armed rig are never removed."""

from __future__ import annotations

import json
import signal
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from daemon.cycle.log_stream import RecordKind
from daemon.loop.command import LoopCommand
from daemon.modes.mode_machine import OperatorAction
from daemon.processes.recorder import KEPT_STANDBY, Recorder, Session
from recording.evaluation.replay import reexecute
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.support.daemon.rigs import JOG, RIG, simple_rig
from tests.support.daemon.running_daemon import RunningDaemon, arm, until

pytestmark = pytest.mark.clock


def test_no_cycle_from_start_to_end_is_missing_in_the_logs(tmp_path: Path) -> None:
    with RunningDaemon(tmp_path) as daemon:
        with daemon.wait_until_ready() as client:
            arm(client)
            client.call("disarm")
            before = client.call("status")["cycle"]
            until(lambda: client.call("status")["cycle"] > before + 200)
        daemon.process.send_signal(signal.SIGTERM)
        assert daemon.process.wait(20) == 0
        paths = list(daemon.logs.glob("*.mcap"))
        logs = sorted((read_log(path) for path in paths), key=lambda log: int(log.columns["cycle"][0]))
        assert [log.metadata["recording"]["span"] for log in logs] == ["standby", "armed", "standby"]
        assert all(log.complete for log in logs)
        cycles = np.concatenate([log.columns["cycle"].astype(np.int64) for log in logs])
        assert cycles[0] == 1
        assert np.all(np.diff(cycles) == 1)
        assert all(first.path.stem.endswith("-standby") != second.path.stem.endswith("-standby") for first, second in pairwise(logs))
        assert all(reexecute(log.path).identical for log in logs)


def test_old_standby_recordings_make_room_and_armed_ones_stay(tmp_path: Path) -> None:
    recorder = Recorder(Session.of(RIG, tmp_path, {}))
    second_ns = 10**9
    for number in range(KEPT_STANDBY + 3):
        for span in ("standby", "armed"):
            content = {"controller_state": {}, "facts": {"span": span}}
            recorder.handle(RecordKind.OPEN, number * second_ns, json.dumps(content).encode())
            recorder.handle(RecordKind.CLOSE, number * second_ns, b"{}")
    names = sorted(path.name for path in tmp_path.glob("*.mcap"))
    standby = [name for name in names if name.endswith("-standby.mcap")]
    assert len(standby) == KEPT_STANDBY
    assert standby[-1] == max(standby)
    assert len(names) - len(standby) == KEPT_STANDBY + 3


def test_standby_recordings_of_a_rig_whose_name_goes_on_are_another_rigs(tmp_path: Path) -> None:
    others = [tmp_path / f"{RIG.rig.name}-2-20260101-00000{number}-standby.mcap" for number in range(KEPT_STANDBY + 2)]
    for path in others:
        path.write_bytes(b"")
    Recorder(Session.of(RIG, tmp_path, {})).handle(
        RecordKind.OPEN, 0, json.dumps({"controller_state": {}, "facts": {"span": "standby"}}).encode()
    )
    assert all(path.exists() for path in others)


def test_a_new_recorder_gets_a_recording_of_its_own(tmp_path: Path) -> None:
    """The one before had begun a standby recording that is good for ten minutes; the new one knows nothing of it."""
    with simple_rig(tmp_path) as (rig, _):
        rig.loop._span._standby = True  # as in the daemon
        rig.cycles(20)
        began = int(rig.value("cycle"))
        rig.recorder.abandon()
        rig.commands.post(LoopCommand(OperatorAction.RESET, new_recorder=True))
        rig.cycles(50)
        rig.arm()
    logs = [read_log(path) for path in rig.recorder.finished]
    assert [log.metadata["recording"]["span"] for log in logs] == ["standby", "armed"]
    assert began < logs[0].columns["cycle"][0] < began + 5
    assert logs[0].columns["cycle"][-1] + 1 == logs[1].columns["cycle"][0]


def test_an_announced_run_stands_in_one_recording_with_its_request(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("daemon.loop.recording_span.ARMED_S", 0.5)
    with simple_rig(tmp_path) as (rig, _):
        rig.arm()
        rig.start({**JOG, "countdown_s": 2.0})
        rig.until(lambda: rig.mode is Mode.RUNNING, 5.0)
        rig.until(lambda: rig.mode is Mode.HOLDING, 20.0)
        rig.cycles(10)
    logs = [read_log(path) for path in rig.recorder.finished]
    (of_run,) = (log for log in logs if np.any(log.columns["maneuver"] == 1))
    assert "run-1.json" in of_run.attachments
    assert reexecute(of_run.path).identical


def test_a_long_armed_recording_is_cut_between_runs_and_every_part_re_executes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("daemon.loop.recording_span.ARMED_S", 0.5)
    with simple_rig(tmp_path) as (rig, _):
        rig.arm()
        for _ in range(2):  # the first cut falls into this run and waits for its end
            rig.start(JOG)
            rig.until(lambda: rig.mode is Mode.RUNNING, 3.0)
            rig.until(lambda: rig.mode is Mode.HOLDING, 20.0)
            rig.cycles(700)
        rig.post(OperatorAction.DISARM)
        rig.until(lambda: rig.mode is Mode.DISARMED, 3.0)
    logs = [read_log(path) for path in rig.recorder.finished]
    armed = [log for log in logs if log.metadata["recording"]["span"] == "armed"]
    assert len(armed) >= 4
    for first, second in pairwise(armed):
        assert first.columns["cycle"][-1] + 1 == second.columns["cycle"][0]
        assert first.metadata["closing"]["ended_by"] == "continued in the next recording"
        assert second.columns["mode"][0] == Mode.HOLDING
    assert all(reexecute(log.path).identical for log in armed)
