"""The commands on a real log, as a newcomer types them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig
from daemon.cli.main import main
from daemon.lockstep import run_lockstep
from recording.files.reader import read_log
from tests.support.measured_data import EMPS, MEASURED_DATA


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    request = {"maneuver": {"name": "jog"}}
    return run_lockstep(load_rig("ornl_testbed"), [request], tmp_path_factory.mktemp("log"))[0]


def test_replay_is_bit_identical(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(log), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["identical"] is True
    assert answer["cycles"] > 1000


def test_replay_with_a_changed_gain_shows_the_difference(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(log), "--set", "servo.rotary.gain=0.27 V/deg"]) == 0
    assert "rotary.command_V" in capsys.readouterr().out


def test_export_holds_the_contract_names(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "out.csv"
    assert main(["log", "export", str(log), "-o", str(table), "--columns", "rotary.position", "rotary.command_V"]) == 0
    heading = table.read_text().splitlines()[0]
    assert heading == "t_s,rotary.position,rotary.command_V"
    turned = np.genfromtxt(table, delimiter=",", names=True)["rotaryposition"]
    assert np.degrees(turned[-1] - turned[0]) == pytest.approx(2.0, abs=0.1)


def test_replay_of_a_log_with_a_flipped_byte_says_so(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In a chunk: its cycles are missing. In an attachment that no run needs: all cycles are there, and the checksum is wrong."""
    data = bytearray(log.read_bytes())
    data[data.index(b"foxglove_layout.json") + 200] ^= 0x01
    (tmp_path / "a.mcap").write_bytes(data)
    main(["replay", str(tmp_path / "a.mcap")])
    said = capsys.readouterr().out
    assert "bit-identical" in said
    assert "checksum" in said


def test_every_verb_takes_several_logs_and_one_that_is_none_does_not_keep_it_from_the_others(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "other.mcap"
    other.write_bytes(b"no log")
    assert main(["log", "check", str(log), str(other), str(log)]) == 3
    said = capsys.readouterr()
    assert said.out.count(f"{log}: good") == 2
    assert str(other) in said.err
    assert main(["replay", str(log), str(log)]) == 0
    assert capsys.readouterr().out.count("bit-identical") == 2
    assert main(["log", "export", str(log), str(log), "-o", str(tmp_path / "x.csv")]) == 2
    assert "one output cannot hold several logs" in capsys.readouterr().err


def test_with_a_rig_file_the_check_says_what_the_gap_would(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """That is no fault of the log: it stays good."""
    assert main(["log", "check", str(log), "--rig", "ornl_testbed"]) == 0
    said = capsys.readouterr().out
    assert f"{log}: good" in said
    assert "warning gap           rotary.return_pressure: more than a fifth of the samples stand at the end of the sensor's range" in said
    assert main(["log", "check", str(log), "--rig", "force_axis"]) == 3
    assert "warning gap" not in capsys.readouterr().out


def test_plot_is_a_picture(log: Path, tmp_path: Path) -> None:
    picture = tmp_path / "plot.png"
    assert main(["log", "plot", str(log), "-o", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.skipif(not EMPS.is_dir(), reason="the measured EMPS data are not beside the project")
@pytest.mark.parametrize("name", ["emps_estimation", "emps_pulses_test"])
def test_measured_axis_comes_in_through_the_shipped_map(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / f"{name}.mcap"
    assert main(["import", str(EMPS / f"{name}.csv"), "--map", "emps", "-o", str(out)]) == 0
    for verb in ("info", "check", "plot"):
        assert main(["log", verb, str(out)]) == 0
    said = capsys.readouterr().out
    assert "24841 cycles" in said
    assert "24.840 s at 1000 Hz" in said


PUBLIC = [  # table, map, rig file and how long it may be: no set may need more of it than it did at first
    ("emps/emps_estimation.csv", "emps", "force_axis", 81),
    ("cu_rotary_arm_rigid_flex/rigidarm_K1_6.csv", "cu_rigid_arm", "cu_rigid_arm", 75),
    ("cu_rotary_arm_rigid_flex/flexarm_K1_6.csv", "cu_flexible_arm", "cu_flexible_arm", 86),
    ("pneumatic_seal_friction/KDN_1bar.csv", "seal_rig", "seal_rig", 65),
    ("rotary_hydraulic_actuator_faults/baseline1_0.csv", "rotary_actuator", "rotary_actuator", 75),
]


@pytest.mark.skipif(not MEASURED_DATA.is_dir(), reason="the measured data are not beside the project")
@pytest.mark.parametrize(("table", "map_name", "rig", "lines"), PUBLIC, ids=[row[1] for row in PUBLIC])
def test_every_public_set_comes_in_with_a_rig_file_no_longer_than_it_was(
    table: str, map_name: str, rig: str, lines: int, tmp_path: Path
) -> None:
    out = tmp_path / "log.mcap"
    assert main(["import", str(MEASURED_DATA / table), "--map", map_name, "-o", str(out)]) == 0
    loaded = load_rig(rig)
    assert len(loaded.text.splitlines()) <= lines
    columns = read_log(out).columns
    assert all(f"{joint}.position" in columns for joint in loaded.rig.joints)
