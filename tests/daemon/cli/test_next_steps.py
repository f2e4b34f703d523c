"""The command told after a refusal: the real parser takes it, it names what it is about, and it is not the refused one again."""

from __future__ import annotations

import shlex
import socket
import sys
from pathlib import Path

import pytest

from config.loading.load import load_rig
from config.loading.shipped import find
from daemon.cli.command_line import build_parser
from daemon.cli.main import main
from daemon.cli.refusal import next_command
from daemon.lockstep import run_lockstep
from daemon.server.protocol import no_answer

OF_THE_SYSTEM = ("ls", "df", "ip", "systemctl", "journalctl", "pip")
SHIPPED = find("rigs", "ornl_testbed").parents[1]
TABLE = "t_s,axis.position\n0,1\n0.5,1\n1,1\n1,2\n2,3\n3,3\n"  # a row has the stamp of the row before


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short real log, two files that are none, and a table, in a folder with a space in its name."""
    place = tmp_path_factory.mktemp("my logs")
    run_lockstep(load_rig("ornl_testbed"), [{"maneuver": {"name": "jog"}}], place)[0].rename(place / "a b.mcap")
    (place / "empty.mcap").write_bytes(b"")
    (place / "rig.yaml").write_text(load_rig("force_axis").text)
    (place / "nothing.yaml").write_text("")
    (place / "notes.mcap").write_text("notes")
    (place / "dup.csv").write_text(TABLE)
    (place / "dup.mat").write_bytes(b"MATLAB 5.0 MAT-file")
    return place


def assert_taken(typed: str, words: list[str]) -> None:
    """By the real parser, where it is a command of ours."""
    first, *rest = shlex.split(typed)
    assert rest != words
    if first in OF_THE_SYSTEM:
        return
    if first == "longreachd":
        assert load_rig(*rest)
        return
    assert first == "longreach"
    if rest[-1] == "--help":
        with pytest.raises(SystemExit) as helped:
            build_parser().parse_args(rest)
        assert helped.value.code == 0
    else:
        build_parser().parse_args(rest)


@pytest.mark.parametrize(
    ("typed", "status", "expected"),
    [
        ("why 'a b.mcap' --at 100", 2, "log info 'a b.mcap'"),
        ("log report 'a b.mcap' --run 5", 2, "log info 'a b.mcap'"),
        ("log diff 'a b.mcap' 'a b.mcap' --runs 2 1", 2, "log info 'a b.mcap'"),
        ("log incident 'a b.mcap'", 3, "log info 'a b.mcap'"),
        ("log info empty.mcap", 3, "runs ."),
        ("log info notes.mcap", 3, "runs ."),
        ("log check empty.mcap", 3, "runs ."),
        ("log info dup.csv", 3, "import dup.csv --suggest"),
        ("log info dup.mat", 3, "import dup.mat --suggest"),
        ("log report --all 'a b.mcap'", 2, "log report 'a b.mcap'"),
        ("log recover --all 'a b.mcap'", 2, "log recover 'a b.mcap'"),
        ("log recover", 2, "log recover --all ."),
        ("log export 'a b.mcap' --columns foo", 2, "log info 'a b.mcap'"),
        ("log export 'a b.mcap' --columns rotary.positio", 2, "log export 'a b.mcap' --columns rotary.position"),
        ("log export 'a b.mcap' -o x.parquet", 1, "pip install 'longreach[parquet]'"),
        ("log plot 'a b.mcap' --signals 'zz*'", 2, "log info 'a b.mcap'"),
        ("log plot 'a b.mcap' --from 50", 2, "log plot 'a b.mcap'"),
        ("log plot 'a b.mcap' -o empty.mcap/x.png", 1, "ls ."),
        ("play 'a b.mcap' top --speed 0", 2, "play 'a b.mcap' top --speed 0.01"),
        ("check 'a b.mcap'", 1, "log info 'a b.mcap'"),
        ("import dup.csv -o d.mcap", 3, "import dup.csv -o d.mcap --to 0.5"),
        ("faults --only zzz", 2, "faults --help"),
        ("faults --only 'recorder SIGKILed'", 2, "faults --only 'recorder SIGKILLed'"),
        ("device scan socketcan:can9", 1, "ip link show can9"),
        ("device read tcp:localhost", 2, "device scan tcp:localhost"),
        ("gap watch --rig force_axis --logs dup.csv --since 2026-05-01", 3, "gap watch --rig force_axis --logs . --since 2026-05-01"),
        ("gap next --rig force_axis", 1, "gap next --rig force_axis --between stiction@axis asymmetric_friction@axis"),
        ("import dup.csv -o .", 2, "import dup.csv -o log.mcap"),
        ("import dup.csv -o d.txt", 2, "import dup.csv -o d.mcap"),
        ("log recover 'a b.mcap' -o d.csv", 2, "log recover 'a b.mcap' -o d.mcap"),
        ("simulate ornl_testbed hold -o b.csv", 2, "simulate ornl_testbed hold -o b.mcap"),
        ("runs nowhere", 3, "ls ."),
        ("simulate ornl_testbed rig.yaml", 1, "check rig.yaml"),
        ("simulate ornl_testbed nothing.yaml", 1, f"ls {SHIPPED / 'rigs'} {SHIPPED / 'maneuvers'}"),
        ("simulate ornl_testbed joint_steps --set 'maneuver.steps.0.by=3 deg'", 1, "simulate --help"),
        ("demo --set y0", 1, "demo --set 'y0=40 in'"),
        ("simulate ornl_testbed jog --shaper three_term --delay 70", 1, "simulate ornl_testbed jog --shaper three_term"),
        ("simulate force_axis jog --shaper three_term --set maneuver.joint=axis --set 'maneuver.by=2 mm'", 1, "simulate --help"),
        ("identify --what multisine --temperatures '2000 degC'", 2, "identify --what multisine"),
        ("identify --what map --extensions '30 in, 200 in'", 2, "identify --what map"),
        (
            "device calibrate ornl_testbed_can rotary.position --at '0 deg=5' --at '9 deg=5'",
            1,
            "device watch ornl_testbed_can rotary_encoder",
        ),
    ],
)
def test_the_next_step_is_one(
    typed: str, status: int, expected: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    monkeypatch.setitem(sys.modules, "pyarrow", None)  # not installed
    words = shlex.split(typed)
    assert main(words) == status
    said = capsys.readouterr().err.splitlines()[-1].removeprefix("next: ")
    assert said == (expected if expected.split()[0] in OF_THE_SYSTEM else f"longreach {expected}")
    assert_taken(said, words)


def test_the_part_of_a_table_that_is_advised_can_be_imported(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    assert main(["import", "dup.csv", "-o", str(tmp_path / "d.mcap")]) == 3
    assert main(shlex.split(capsys.readouterr().err.splitlines()[-1].removeprefix("next: longreach "))) == 0


def test_where_nobody_answers_no_daemon_is_asked_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket(socket.AF_UNIX) as stale:
        stale.bind(str(tmp_path / "stale.sock"))
    words = ["--socket", str(tmp_path / "stale.sock"), "why"]
    assert main(words) == 1
    assert_taken(capsys.readouterr().err.splitlines()[-1].removeprefix("next: "), words)
    forbidden = no_answer("/run/a.sock", PermissionError(13, "Permission denied"))
    forbidden.__cause__ = PermissionError()
    assert_taken(next_command(forbidden, words, build_parser().parse_args(words)), words)


def test_info_shows_the_range_that_a_moment_lies_in(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["log", "info", str(folder / "a b.mcap")]) == 0
    assert "\n  t_s 0.004 to 1.358 s\n" in capsys.readouterr().out
