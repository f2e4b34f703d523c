"""Every cycle is in a log, also while disarmed; standby recordings are bounded, recordings of an armed rig are never removed."""

from __future__ import annotations

import json
import signal
from itertools import pairwise
from pathlib import Path

import numpy as np
from rigs import RIG
from running_daemon import RunningDaemon, arm, until

from daemon.log_stream import Kind
from daemon.recorder import KEPT_STANDBY, Recorder, Session
from recording.reader import read_log
from recording.replay import reexecute


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
    recorder = Recorder(Session(RIG, tmp_path, {}))
    second_ns = 10**9
    for number in range(KEPT_STANDBY + 3):
        for span in ("standby", "armed"):
            content = {"controller_state": {}, "facts": {"span": span}}
            recorder.handle(Kind.OPEN, number * second_ns, json.dumps(content).encode())
            recorder.handle(Kind.CLOSE, number * second_ns, b"{}")
    names = sorted(path.name for path in tmp_path.glob("*.mcap"))
    standby = [name for name in names if name.endswith("-standby.mcap")]
    assert len(standby) == KEPT_STANDBY
    assert standby[-1] == max(standby)
    assert len(names) - len(standby) == KEPT_STANDBY + 3
