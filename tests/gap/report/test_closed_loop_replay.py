"""The closed-loop replay of an MCAP log and of the same log as a table, with and without what says how it was run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from config.loading.load import LoadedRig, rig_from_text
from config.schema.maneuver import maneuver_from_content
from daemon.lockstep import run_lockstep
from gap.data.logged_run import FollowedReference
from gap.maneuvers.designs import ManeuverDesign
from gap.report.replay import JointReplay, replays
from recording.files.reader import read_log
from tests.support.gap import axis_logs

AT = {"start": {"axis": "0.125 m"}, "joint": "axis"}
DESIGN = ManeuverDesign("staircase", AT | {"step": "10 mm", "steps": 2, "hold": "0.3 s"})
MODEL, TRUTH = axis_logs.axis_rig("coulomb_friction"), axis_logs.axis_rig()


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    text = axis_logs.axis_text()
    return run_lockstep(LoadedRig(rig_from_text(text), text, "axis.yaml"), [DESIGN.request], tmp_path_factory.mktemp("replay"), seed=3)[0]


def table(log: Path, path: Path, *without: str) -> Path:
    """The log as CSV, without some columns."""
    columns = {name: np.asarray(values, dtype=float) for name, values in read_log(log).columns.items() if name not in without}
    columns = {name: values for name, values in columns.items() if np.isfinite(values).any()}
    return axis_logs.write(path, columns)


def one(found: list[JointReplay] | str) -> JointReplay:
    assert not isinstance(found, str), found
    return found[0]


def test_a_table_is_run_again_as_its_log_is(log: Path, tmp_path: Path) -> None:
    """The reference stands in the table: the improved rig repeats commands and errors, the one without friction does not."""
    whole, followed = one(replays(log, MODEL, TRUTH)), one(replays(table(log, tmp_path / "a.csv"), MODEL, TRUTH))
    assert whole.rms()[1] < 0.3 * whole.rms()[0]
    np.testing.assert_allclose(followed.rms(), whole.rms(), rtol=0.15)


def test_the_maneuver_can_be_given_and_its_begin_is_found(log: Path, tmp_path: Path) -> None:
    """Nothing but position and command is in the table; it begins before the run, and its rate is not the loop's."""
    bare = table(log, tmp_path / "bare.csv", "mode", "axis.reference", "axis.reference_rate")
    said = replays(bare, MODEL, TRUTH)
    assert isinstance(said, str)
    assert "axis.reference" in said
    assert "--request" in said
    maneuver = tmp_path / "maneuver.yaml"
    maneuver.write_text(_yaml(DESIGN))
    whole, given = one(replays(log, MODEL, TRUTH)), one(replays(bare, MODEL, TRUTH, maneuver))
    count = min(len(whole.t_s), len(given.t_s))
    np.testing.assert_allclose(given.commands_V[0][:count], whole.commands_V[0][:count], atol=0.05 * np.ptp(whole.commands_V[0]))
    assert given.rms()[1] < 0.3 * given.rms()[0]


def test_a_request_as_the_log_holds_it_can_be_given(log: Path, tmp_path: Path) -> None:
    attached = next(data for name, data in read_log(log).attachments.items() if name.startswith("run-"))
    request = tmp_path / "request.json"
    request.write_bytes(attached)
    bare = table(log, tmp_path / "bare.csv", "axis.reference", "axis.reference_rate")
    given, whole = one(replays(bare, MODEL, TRUTH, request)).rms(), one(replays(log, MODEL, TRUTH)).rms()
    np.testing.assert_allclose(given[:2], whole[:2], rtol=1e-3)
    np.testing.assert_allclose(given[2:], whole[2:], rtol=0.1)  # the reference is the planned one, which leaves from another held position


def test_what_cannot_be_planned_is_said(log: Path, tmp_path: Path) -> None:
    request = tmp_path / "request.json"
    request.write_text('{"maneuver": {}}')
    said = replays(log, MODEL, TRUTH, request)
    assert isinstance(said, str)
    assert "wrong keys" in said


def test_the_reference_that_is_followed_is_the_logged_one() -> None:
    columns = {"axis.reference": np.array([0.0, 0.001, 0.003, 0.003])}
    piece = FollowedReference(columns, TRUTH)
    assert piece.duration_s == pytest.approx(0.003)
    assert [piece.at(t)[0][0] for t in (0.0, 0.001, 0.002, 0.1)] == [0.0, 0.001, 0.003, 0.003]
    assert piece.at(0.001)[1][0] == pytest.approx(1.5)  # central difference of the positions


def _yaml(design: ManeuverDesign) -> str:
    content = design.content
    assert maneuver_from_content(content)
    return str(yaml.safe_dump(content))
