"""What a user reads when something is wrong with what he gave, command by command, and that nothing is lost by it."""

from __future__ import annotations

import io
import json
import shlex
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
    assert "2 problems in" in said  # effects of the link have none of their own
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


def test_every_problem_of_a_file_is_in_the_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = rig_file(tmp_path, "payload: 45 lb", "payload: 45 psi")
    path.write_text(path.read_text().replace("payload: 45 lb", "payload: 45 psi"))
    assert main(["check", str(path), "--json"]) == 1
    problems = json.loads(capsys.readouterr().out)["error"]["problems"]
    assert [problem["value"] for problem in problems] == ["'45 psi'", "'45 psi'"]


def test_of_several_logs_the_json_is_one_array(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(log.read_bytes()[: log.stat().st_size * 2 // 3])
    (tmp_path / "empty.mcap").write_bytes(b"")
    assert main(["log", "info", str(tmp_path / "none.mcap"), str(log), "--json"]) == 3
    refused, told = json.loads(capsys.readouterr().out)
    assert (refused["error"]["class"], told["rig_name"]) == ("LogError", "ornl_testbed")
    assert main(["log", "recover", "--all", str(tmp_path), "--json"]) == 3
    repaired, refused = json.loads(capsys.readouterr().out)
    assert (repaired["source"], refused["error"]["class"]) == (str(cut), "LogError")


def test_no_daemon_says_how_to_start_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--socket", str(tmp_path / "none.sock"), "status"]) == 1
    said = capsys.readouterr().err
    assert str(tmp_path / "none.sock") in said
    assert said.splitlines()[-1] == "next: longreachd ornl_testbed"


def test_maneuver_outside_the_workspace_moves_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--lockstep", "--out", str(tmp_path), "--set", "y0=10 in"]) == 1
    said = capsys.readouterr().err
    assert "extension 10 in" in said
    assert "below the limit 12 in" in said


@pytest.mark.parametrize(
    ("words", "said", "typed"),
    [
        (["demo", "--rig", "force_axis"], "a straight line needs the joints rotary, prismatic: axis", "longreach demo"),
        (["demo", "--set", "y0=10 in"], "Choose y0 ≥ 12 in", "longreach demo --set 'y0=12.02 in'"),
        (["demo", "--set", "y0"], "a parameter is written KEY=VALUE", "longreach demo --set 'y0=40 in'"),
        (["demo", "--set", "y0=10 psi"], "wrong kind of unit: '10 psi'", "longreach demo --set 'y0=40 in'"),
        (["demo", "--set", "y0=12 m"], "out of range: 12 m (limit: 0.05 to 10 m)", "longreach demo --set 'y0=40 in'"),
        (
            ["demo", "--set", "moves=[3 in, x]"],
            "not a number with a unit: 'x'",
            "longreach demo --set 'moves=[30 in, -60 in, 30 in]'",
        ),
        (["demo", "--set", "speeed=9 in/s"], "nearest is 'speed'", "longreach demo --set 'speed=9 in/s'"),
        (["demo", "--rig", "ornl_testbe"], "nearest is 'ornl_testbed'", "longreach demo --rig ornl_testbed"),
        (["shape", "force_axis"], "no link_mode", "longreach check force_axis"),
        (["shape", "--set", "y0=10 in"], "extension 10 in at t = 0.00 s is below the limit 12 in", "longreach shape --set 'y0=12.02 in'"),
        (["shape", "--allowed", "3x"], "unknown unit: '3x'", "longreach shape --help"),
        (["identify", "--joint", "rotar"], "nearest is 'rotary'", "longreach identify --joint rotary"),
        (["identify", "--on-rig", "--payloads", "0 lb"], "Leave --temperatures and --payloads out", "longreach identify --on-rig"),
        (["identify", "--payloads", "0 lb, 45 psi"], "wrong kind of unit: '45 psi'", "longreach identify"),
        (["identify", "--band", "1 Hz"], "Give 2, or leave --band out", "longreach identify"),
        (["new-driver", "My-Gauge"], "not usable as the name", "longreach new-driver my_gauge"),
        (["device", "scan", "can0"], "a CAN bus is INTERFACE:CHANNEL", "longreach device scan socketcan:can0"),
        (["device", "options", "modbuss"], "nearest is 'modbus", "longreach device options modbus"),
        (
            ["gap", "loop", "--rig", "a.yaml", "--truth-rig", "force_axis", "--log", "a.mcap"],
            "go together",
            "longreach gap loop --rig a.yaml --truth-rig force_axis",
        ),
        (["gap", "loop", "--rig", "force_axis", "--truth-rig", "ornl_testbed"], "other joints than the model", "longreach gap loop --help"),
        (["identify", "force_axis"], "one hydraulic axis", "longreach identify --log LOG.mcap"),
    ],
)
def test_the_next_command_is_the_refused_one_with_what_fits(
    words: list[str], said: str, typed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(words) in (1, 2)
    told = capsys.readouterr()
    assert said in told.err
    assert told.err.splitlines()[-1] == f"next: {typed}"
    assert "measuring" not in told.out
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("setting", "own"),
    [
        ("servo.rotary.gain=0.3 V/psi", "servo.rotary.gain=0.35 V/deg"),
        ("servo.rotary.gain=abc", "servo.rotary.gain=0.35 V/deg"),
        ("servo.rotary.gain=9e9 V/deg", "servo.rotary.gain=0.35 V/deg"),
        ("servo.rotary.gain", "servo.rotary.gain=0.35 V/deg"),
        ("joints.rotary.travel=[1 psi, 2]", "joints.rotary.travel=[-88 deg, 88 deg]"),
        ("plant.effects.0.friction=3 kg", "plant.effects.0.friction=105 N*m"),
    ],
)
def test_a_refused_change_of_a_rig_is_answered_with_what_its_file_has(
    setting: str, own: str, log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Not with the number in another unit: 0.3 V/rad is 57 times less than 0.3 V/deg."""
    assert main(["replay", str(log), "--set", "loop.rate=1 kHz", "--set", setting]) == 1
    assert capsys.readouterr().err.splitlines()[-1] == shlex.join(
        ["next:", "longreach", "replay", str(log), "--set", "loop.rate=1 kHz", "--set", own]
    )


@pytest.mark.parametrize("at", ["0 deg=nan", "0 mm=0", "0 degg=0"])
def test_no_known_value_of_a_sensor_is_invented(at: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["device", "calibrate", "ornl_testbed", "rotary.position", "--at", at]) == 1
    said = capsys.readouterr().err.splitlines()
    assert said[0].startswith("longreach: --at: ")
    assert said[1] == "next: longreach device calibrate --help"


def test_what_to_change_in_a_maneuver_file_is_told_with_its_line_and_the_same_command_is_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text = find("maneuvers", "paper_line").read_text(encoding="utf-8")
    own = tmp_path / "near.yaml"
    own.write_text(text.replace("y0: 40 in", "y0: 10 in"), encoding="utf-8")
    words = ["simulate", "ornl_testbed", "near.yaml", "-o", "near.mcap"]
    assert main(words) == 1
    said = capsys.readouterr().err.splitlines()
    assert said[-2] == f"change near.yaml:{line_of(own, 'y0:')}: y0: 12.02 in"
    assert said[-1] == "next: longreach simulate ornl_testbed near.yaml -o near.mcap"
    assert main([*words, "--set", "maneuver.y0=11 in"]) == 1
    assert capsys.readouterr().err.splitlines()[-1].endswith("-o near.mcap --set 'maneuver.y0=12.02 in'")
    assert main([*words, "--set", "y0=30 in"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert "y0 is a key of the maneuver" in said[0]
    assert said[-1].endswith("-o near.mcap --set 'maneuver.y0=30 in'")


@pytest.mark.parametrize(
    ("words", "typed"),
    [
        (["simulate", "ornl_testbed", "hold", "-o", "there.mcap"], "longreach simulate ornl_testbed hold -o there-2.mcap"),
        (["new-rig", "there", "--kind", "cylinder"], "longreach new-rig there --kind cylinder -o there-2"),
        (["new-rig", "3 Achsen", "--kind", "cylinder"], "longreach new-rig achsen --kind cylinder"),
        (["new-rig", "axis", "--iso-vg", "46"], "longreach new-rig axis --iso-vg 46 --kind cylinder"),
        (["new-rig", "axis", "--kind", "cylinder"], "longreach new-rig axis --kind cylinder"),
        (["commission", "ornl_testbed"], "longreach commission ornl_testbed --yes"),
        (["log", "report"], "longreach log report --all ."),
        (["log", "recover"], "longreach log recover --all ."),
        (["simulate", "ornl_testbed", "hold", "-o", "b.csv"], "longreach simulate ornl_testbed hold -o b.mcap"),
        (["log", "plot", "a.mcap", "b.mcap", "-o", "a.png"], "longreach log plot a.mcap b.mcap"),
        (["design", "force_axis", "--schedule", "--tip-gain", "0.1"], "longreach design force_axis"),
        (["runs", ".", "--since", "yesterday"], "longreach runs . --since 2026-05-31"),
        (["import", "table.csv"], "longreach import table.csv -o table.mcap"),
        (["import", "table.csv", "-o", "out.mcap"], "longreach import table.csv -o out.mcap"),
    ],
)
def test_the_command_to_type_again_has_what_fits(
    words: list[str], typed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The last one once the table is mended."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO())
    for place in (tmp_path / "there.mcap", tmp_path / "there" / "notes.txt"):
        place.parent.mkdir(exist_ok=True)
        place.write_text("mine")
    (tmp_path / "table.csv").write_text("t_s,axis.position\n0,1\n1\n")
    assert main(words) != 0
    assert capsys.readouterr().err.splitlines()[-1] == f"next: {typed}"


def test_a_table_of_a_damaged_log_says_what_it_lacks(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = bytearray(log.read_bytes())
    content[len(content) // 2] ^= 0x10
    (tmp_path / "flip.mcap").write_bytes(content)
    assert main(["log", "export", str(tmp_path / "flip.mcap")]) == 0
    told = capsys.readouterr().err
    assert "The log is damaged: " in told
    assert "cut" not in told
    assert "`longreach log recover`" in told


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


def test_a_maneuver_file_that_is_not_utf8_is_told_with_its_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "latin.yaml"
    path.write_bytes("longreach: maneuver/1\n# Höhe\n".encode("latin-1"))
    assert main(["simulate", "ornl_testbed", str(path), "-o", str(tmp_path / "a.mcap")]) == 1
    assert f"{path}:2:4: the file is not UTF-8 text: byte 0xf6" in capsys.readouterr().err
