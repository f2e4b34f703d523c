"""What a user reads when something is wrong with what he gave, command by command, and that nothing is lost by it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from config.loading.load import load_rig
from config.loading.shipped import find
from daemon.cli.main import main
from daemon.lockstep import run_lockstep

JOG = {"maneuver": {"name": "jog"}}


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short real log of the testbed."""
    return run_lockstep(load_rig("ornl_testbed"), [JOG], tmp_path_factory.mktemp("log"))[0]


def rig_file(tmp_path: Path, old: str, new: str) -> Path:
    text = find("rigs", "ornl_testbed").read_text(encoding="utf-8")
    assert text.count(old) >= 1
    path = tmp_path / "rig.yaml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


def line_of(path: Path, text: str) -> int:
    return next(number for number, line in enumerate(path.read_text().splitlines(), 1) if text in line)


def test_once_the_lines_of_a_file_are_mended_the_same_command_is_next(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = rig_file(tmp_path, "payload: 45 lb", "payload: 45 psi")
    path.write_text(path.read_text().replace("payload: 45 lb", "payload: 45 psi"))
    assert main(["check", str(path)]) == 1
    said = capsys.readouterr().err
    assert "problems in" in said
    assert said.splitlines()[-1] == f"next: longreach check {path}"


def test_unknown_key_is_named_with_place_and_nearest(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = rig_file(tmp_path, "    gain: ", "    gian: ")
    assert main(["check", str(path)]) == 1
    said = capsys.readouterr().err
    assert f"{path}:{line_of(path, 'gian')}:5: servo.rotary.gian" in said
    assert "nearest is 'gain'" in said


def test_wrong_unit_says_which_is_wanted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = rig_file(tmp_path, "pressure: 2000 psi", "pressure: 2000 kg")
    assert main(["check", str(path)]) == 1
    said = capsys.readouterr().err
    assert f"{path}:{line_of(path, '2000 kg')}:" in said
    assert "2000 kg" in said
    assert "Pa" in said


def test_value_out_of_range_shows_the_range(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = rig_file(tmp_path, "rate: 1 kHz", "rate: 20 kHz")
    assert main(["check", str(path)]) == 1
    said = capsys.readouterr().err
    assert f"{path}:{line_of(path, '20 kHz')}:" in said
    assert "2000" in said


def test_refusals_are_json_for_scripts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = rig_file(tmp_path, "    gain: ", "    gian: ")
    assert main(["check", str(path), "--json"]) == 1
    error = json.loads(capsys.readouterr().out)["error"]
    assert error["class"] == "ConfigError"
    assert "gian" in error["text"]


def test_no_daemon_says_how_to_start_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--socket", str(tmp_path / "none.sock"), "status"]) == 1
    said = capsys.readouterr().err
    assert str(tmp_path / "none.sock") in said
    assert "longreachd RIG.yaml" in said


def test_maneuver_outside_the_workspace_moves_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--lockstep", "--out", str(tmp_path), "--set", "y0=10 in"]) == 1
    said = capsys.readouterr().err
    assert "extension 10 in" in said
    assert "below the limit 12 in" in said


@pytest.mark.parametrize(
    ("words", "said", "typed"),
    [
        (["demo", "--rig", "force_axis"], "a straight line needs the joints rotary, prismatic: axis", "longreach demo"),
        (["demo", "--set", "y0=10 in"], "Choose y0 ≥ 12 in", "longreach demo --help"),
        (["demo", "--set", "y0"], "a parameter is written KEY=VALUE", "longreach demo --help"),
        (["demo", "--rig", "ornl_testbe"], "nearest is 'ornl_testbed'", "longreach demo --rig ornl_testbed"),
        (["shape", "force_axis"], "no link_mode", "longreach check force_axis"),
        (["shape", "--set", "y0=10 in"], "extension 10 in at t = 0.00 s is below the limit 12 in", "longreach shape --help"),
        (["shape", "--allowed", "3x"], "unknown unit: '3x'", "longreach shape --help"),
        (["identify", "--joint", "rotar"], "nearest is 'rotary'", "longreach identify --joint rotary"),
        (["identify", "--on-rig", "--payloads", "0 lb"], "Leave --temperatures and --payloads out", "longreach identify --help"),
        (["identify", "force_axis"], "one hydraulic axis", "longreach identify --log LOG.mcap"),
    ],
)
def test_the_next_command_is_never_the_refused_one(
    words: list[str], said: str, typed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(words) == 1
    told = capsys.readouterr()
    assert said in told.err
    assert told.err.splitlines()[-1] == f"next: {typed}"
    assert "measuring" not in told.out
    assert list(tmp_path.iterdir()) == []


def test_truncated_log_is_read_named_and_repaired(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cut = tmp_path / "cut.mcap"
    whole = log.read_bytes()
    cut.write_bytes(whole[: len(whole) * 2 // 3])
    assert main(["log", "check", str(cut)]) == 3
    assert "cut" in capsys.readouterr().out
    assert main(["log", "recover", str(cut)]) == 0
    assert "Lost:" in capsys.readouterr().out
    assert main(["log", "check", str(tmp_path / "cut-recovered.mcap")]) == 0
    assert cut.read_bytes() == whole[: len(whole) * 2 // 3]


def test_log_of_another_rig_is_told(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["log", "check", str(log), "--rig", "force_axis"]) == 3
    assert "the log is of rig ornl_testbed" in capsys.readouterr().out


def test_empty_table_is_refused_and_writes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "empty.csv"
    table.write_text("")
    out = tmp_path / "out.mcap"
    assert main(["import", str(table), "-o", str(out)]) == 3
    assert str(table) in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [table]


def test_something_that_is_no_log_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = tmp_path / "notes.mcap"
    text.write_text("not a log")
    for verb in ("info", "check", "plot", "export", "recover"):
        assert main(["log", verb, str(text)]) == 3
        assert str(text) in capsys.readouterr().err


def test_replay_with_an_unknown_key_names_the_nearest(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(log), "--set", "servo.rotary.gian=0.5 V/deg"]) == 1
    assert "gain" in capsys.readouterr().err


def test_wrong_usage_is_status_2() -> None:
    with pytest.raises(SystemExit) as ended:
        main(["strat"])
    assert ended.value.code == 2


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["star"], "longreach: there is no command 'star': nearest is 'start'\nnext: longreach start --help\n"),
        (["log", "chek"], "longreach log: there is no command 'chek': nearest is 'check'\nnext: longreach log check --help\n"),
        (["xyzzy"], "longreach: there is no command 'xyzzy'\nnext: longreach --help\n"),
    ],
)
def test_a_command_that_there_is_not_is_answered_with_the_nearest(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert capsys.readouterr().err == said
