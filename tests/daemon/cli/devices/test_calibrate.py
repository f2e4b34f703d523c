"""`longreach device calibrate`: from a node moved by hand, or from counts written down, into the rig file; then `check` knows it."""

from __future__ import annotations

import datetime
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from config.checking.check import check_rig
from config.loading.load import load_rig
from daemon.cli.main import main
from tests.support.drivers.local_nodes import PRE_OPERATIONAL, EncoderNode, NodeBench
from tests.support.sim_backend.twin_rig import PRISMATIC_ENCODER, free_port, twin_rig_text

SENSOR, OIL = "prismatic.position", "reservoir_temperature"
BY_HAND = ["--at", "12 in=60000", "--at", "36 in=36000", "--at", "60 in=12000"]


@pytest.fixture
def rig(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    path = tmp_path / "rig.yaml"
    text = twin_rig_text(request.node.name, free_port()).replace("name: ornl_testbed\n", "# mine\nname: ornl_testbed\n", 1)
    path.write_text(text)
    return path


def calibrate(rig: Path, *words: str) -> int:
    return main(["device", "calibrate", str(rig), SENSOR, *words])


def test_sign_scale_and_zero_from_a_moved_encoder(rig: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """The canopen package's node; Enter moves it: counts fall as the arm goes out, 0.02 mm each, and the last one flickers."""
    with NodeBench("test_sign_scale_and_zero_from_a_moved_encoder") as bench:
        node = EncoderNode(bench, PRISMATIC_ENCODER)
        extensions = iter((0.4, 0.8, 1.2))

        class Hand:
            def readline(self) -> str:
                node.put(0x6004, 0, round((2.0 - next(extensions)) / 0.02e-3))
                return "\n"

        monkeypatch.setattr("sys.stdin", Hand())
        words = ["--at", "0.4 m", "--at", "0.8 m", "--at", "1.2 m", "--readings", "5", "--every", "1 ms", "--write", "--json"]
        assert calibrate(rig, *words) == 0
        assert node.state == PRE_OPERATIONAL
    said = json.loads(capsys.readouterr().out)
    np.testing.assert_allclose([said["scale"], said["offset"]], [-0.02e-3, 2.0], rtol=1e-6)
    assert [point["readings"] for point in said["points"]] == [5, 5, 5]
    calibration = load_rig(rig).rig.signals[SENSOR].calibration
    np.testing.assert_allclose([calibration.scale, calibration.offset], [-0.02e-3, 2.0], rtol=1e-6)
    assert calibration.calibrated_on == datetime.date.today()
    assert "3 points" in calibration.by
    assert "noise 0 in" in calibration.by


def test_the_record_is_dated_and_check_tells_when_it_ends(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = rig.read_text()
    assert calibrate(rig, *BY_HAND, "--valid-days", "30", "--by", "me", "--write") == 0
    assert "The sign turns." in capsys.readouterr().out
    after = rig.read_text()
    assert set(before.splitlines()) - set(after.splitlines()) <= {"      scale: 25 um", "      offset: 0 m"}, "all other lines stay"
    (entry,) = set(after.splitlines()) - set(before.splitlines())
    assert entry.strip().startswith("{scale: -0.001 in, offset: 72 in, calibrated_on:")
    assert 'by: "me: 3 points, residual 0 in, noise not measured"' in entry
    loaded = load_rig(rig)
    later = datetime.date.today() + datetime.timedelta(days=31)
    ended = [each.text for each in check_rig(loaded, later) if f"{SENSOR}: the calibration was valid until" in each.text]
    assert len(ended) == 1
    assert not [each for each in check_rig(loaded, datetime.date.today()) if "calibration was valid" in each.text]


def test_without_write_nothing_is_changed(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = rig.read_text()
    assert calibrate(rig, *BY_HAND) == 0
    assert "not written" in capsys.readouterr().out
    assert rig.read_text() == before


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["--at", "12 in=60000", "--at", "36 in=30000", "--at", "60 in=12000", "--write"],
            "the point 36 in lies off the line of the others: -3.92 in (limit: 0.24 in)",
        ),
        (["--at", "12 in=60000", "--at", "12 in=60000", "--write"], "different known values are needed"),
        (["--at", "12 psi=60000", "--at", "36 in=30000", "--write"], "wrong kind of unit"),
        (["--at", "12 in=sixty", "--at", "36 in=30000", "--write"], "not a number"),
        (["--at", "12 in", "--at", "36 in", "--reference-uncertainty", "1 bar", "--write"], "--reference-uncertainty: wrong kind of unit"),
        (["--at", "12 in", "--at", "36 in", "--noise-limit=-1 mm", "--write"], "--noise-limit: a limit is never negative"),
        (["--at", "12 in", "--at", "36 ft", "--write"], "the known value '36 ft' lies far outside what prismatic.position can be: 432 in"),
    ],
)
def test_a_refusal_leaves_the_file_as_it_was(rig: Path, words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    before = rig.read_text()
    assert calibrate(rig, *words) != 0
    assert message in capsys.readouterr().err
    assert rig.read_text() == before


def test_nothing_is_read_where_no_enter_can_come(rig: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """A closed input, a script: the sensor may stand anywhere."""
    monkeypatch.setattr("sys.stdin", io.StringIO())
    before = rig.read_text()
    with NodeBench("test_nothing_is_read_where_no_enter_can_come") as bench:
        EncoderNode(bench, PRISMATIC_ENCODER)
        assert calibrate(rig, "--at", "0.4 m", "--at", "0.8 m", "--readings", "5", "--every", "1 ms", "--write") == 2
    assert "no Enter came" in capsys.readouterr().err
    assert rig.read_text() == before


def test_wrong_names_and_shipped_rigs_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["device", "calibrate", "ornl_testbed_can", "prismatic.positon", *BY_HAND]) == 2
    assert "nearest is 'prismatic.position'" in capsys.readouterr().err
    assert main(["device", "calibrate", "ornl_testbed_can", SENSOR, *BY_HAND, "--write"]) == 2
    assert "a shipped rig file is not changed" in capsys.readouterr().err


def test_comments_behind_the_old_calibration_go_with_it(tmp_path: Path, capsys: pytest.CaptureFixture[Any]) -> None:
    out = tmp_path / "mine.yaml"
    words = ["--at", "-80 deg=20000", "--at", "80 deg=52000", "-o", str(out)]
    assert main(["device", "calibrate", "ornl_testbed_can", "rotary.position", *words]) == 0
    lines = out.read_text().splitlines()
    (line,) = [each for each in lines if "calibrated_on" in each]
    assert line.endswith("on_expiry: warn}")
    assert lines[lines.index(line) + 1].endswith("# [A] range of the transducer is +-90 deg")


def test_the_record_is_in_the_unit_in_which_the_file_states_the_signal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A temperature: a scale has no zero of its own, an offset has. 32 degF are 0 degC, 0.18 degF a tenth of a kelvin."""
    mine = tmp_path / "mine.yaml"
    mine.write_text(load_rig("analogue_axis").text.replace("low: -5 degC ", "low: 23 degF ").replace("high: 105 degC", "high: 221 degF"))
    assert main(["device", "calibrate", str(mine), OIL, "--at", "32 degF=0", "--at", "212 degF=1000", "--write"]) == 0
    assert "calibration: {scale: 0.18 degF, offset: 32 degF, calibrated_on:" in mine.read_text()
    calibration = load_rig(mine).rig.signals[OIL].calibration
    np.testing.assert_allclose([calibration.scale, calibration.offset], [0.1, 0.0], atol=1e-9)


def test_a_known_value_without_its_unit_is_refused_with_the_unit_of_the_file(
    rig: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """36 is 36 m = 1417 in; the range of the signal is 11.5 to 60.5 in. With the units the next command does what was meant."""
    words = ["--at", "0=60000", "--at", "12=36000", "--at", "36=12000", "--write"]
    before = rig.read_text()
    assert calibrate(rig, *words) == 2
    said = capsys.readouterr().err
    assert "the known value '36' lies far outside what prismatic.position can be: 1417 in (limit: 11.5 to 60.5 in)" in said
    assert "--at '0 in=60000' --at '12 in=36000' --at '36 in=12000' --write" in said.splitlines()[-1]
    assert rig.read_text() == before
