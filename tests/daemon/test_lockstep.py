"""Whole runs of the shipped rig on the virtual clock, with the real simulated plant."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from config.errors import ConfigError, DaemonError, ManeuverError
from daemon.lockstep import run_lockstep
from recording.evaluation.replay import reexecute
from recording.files.check import check_log
from recording.files.reader import read_log
from tests.support.daemon.rigs import JOG, RIG


def cycle_bytes(path: Path) -> str:
    """Digest of every message of /cycle with its time, read by the MCAP project's own reader."""
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        for _, _, message in make_reader(stream).iter_messages(topics=["/cycle"]):
            digest.update(message.log_time.to_bytes(8, "little") + message.data)
    return digest.hexdigest()


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return run_lockstep(RIG, [JOG, {**JOG, "parameters": {"by": "-3 deg"}}], tmp_path_factory.mktemp("logs"))


def test_one_whole_log_for_every_request_with_everything_inside(logs: list[Path]) -> None:
    assert len(logs) == len(set(logs)) == 2
    for number, path in enumerate(logs, 1):
        log = read_log(path)
        assert log.complete
        names = set(log.attachments)
        assert {"rig.yaml", "calibration.json", "foxglove_layout.json", "controller_state.json", "timing_passport.json"} <= names
        assert {f"run-{number}.json", f"maneuver-{number}.yaml"} <= names
        assert log.attachments["rig.yaml"].decode() == RIG.text
        recording = log.metadata["recording"]
        assert (recording["recording_id"], recording["rig_name"], recording["clock"]) == (path.stem, "ornl_testbed", "lockstep")
        assert log.metadata["closing"]["grade"] == "A"
        assert not [finding for finding in check_log(path).findings if finding.grade == "error"]


def test_the_arm_moved_as_asked_and_the_log_shows_it(logs: list[Path]) -> None:
    for path, degrees in zip(logs, (2.0, -3.0), strict=True):
        position = read_log(path).columns["rotary.position"]
        assert position[-1] - position[0] == pytest.approx(np.deg2rad(degrees), abs=np.deg2rad(0.3))


def test_every_log_re_executes_bit_for_bit(logs: list[Path]) -> None:
    for path in logs:
        result = reexecute(path)
        assert result.identical, result.text()


def test_the_same_again_gives_the_same_bytes_and_another_seed_does_not(logs: list[Path], tmp_path: Path) -> None:
    requests = [JOG, {**JOG, "parameters": ["by=-3 deg"]}]
    again = run_lockstep(RIG, requests, tmp_path / "again")
    other = run_lockstep(RIG, requests[:1], tmp_path / "other", seed=1)
    assert [cycle_bytes(path) for path in again] == [cycle_bytes(path) for path in logs]
    assert cycle_bytes(other[0]) != cycle_bytes(logs[0])


def test_raw_counts_and_calibration_give_the_engineering_values(logs: list[Path]) -> None:
    columns = read_log(logs[0]).columns
    for signal, field in (("rotary.position", "rotary.position"), ("rotary.supply_pressure", "rotary.supply_pressure_Pa")):
        calibration = RIG.rig.signals[signal].calibration
        expected = calibration.offset + calibration.scale * columns[f"{signal}_raw"]
        np.testing.assert_allclose(columns[field], expected, rtol=1e-12)


def test_progress_is_told_up_to_the_end(tmp_path: Path) -> None:
    told: list[tuple[int, float, float]] = []
    run_lockstep(RIG, [JOG], tmp_path, progress=lambda *where: told.append(where))
    assert all(number == 0 for number, _, _ in told)
    assert told[-1][1] == pytest.approx(told[-1][2], abs=0.2)


def test_requests_that_cannot_be_run_are_refused(tmp_path: Path) -> None:
    for request, error in (
        ({"maneuver": {"name": "no_such"}}, ConfigError),
        ({"maneuver": {"name": "jog"}, "parameters": {"speeed": 1}}, ConfigError),
        ({"maneuver": {"name": "jog"}, "parameters": {"by": "200 deg"}}, ManeuverError),
        ({"maneuver": {"name": "jog"}, "parameters": ["by"]}, ManeuverError),
        ({"maneuver": {"name": "jog"}, "parameters": 3}, DaemonError),
        ({"maneuver": 3}, DaemonError),
        ({"maneuver": {"name": "jog"}, "repeat": "twice"}, DaemonError),
        ({"maneuver": {"name": "jog"}, "colour": "red"}, DaemonError),
        ({"maneuver": {"name": "jog"}, "countdown_s": -1.0}, DaemonError),
        ({"maneuver": {"text": "longreach: maneuver/1\nname: x\nkind: fly\n"}}, ConfigError),
    ):
        with pytest.raises(error):
            run_lockstep(RIG, [request], tmp_path)
