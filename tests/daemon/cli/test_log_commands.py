"""The commands on a real log, as a newcomer types them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from config.load import load_rig
from daemon.cli.main import main
from daemon.lockstep import run_lockstep

EMPS = Path(__file__).resolve().parents[4] / "shared" / "data" / "emps"


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
