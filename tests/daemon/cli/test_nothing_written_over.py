"""What stands in a file that a command would write is not lost: the name of a log or a rig file given by a slip, an earlier result."""

from __future__ import annotations

from pathlib import Path

import pytest

from config.loading.load import load_rig
from config.loading.shipped import find
from daemon.cli.main import main
from daemon.lockstep import run_lockstep

MINE = b"mine"


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_lockstep(load_rig("ornl_testbed"), [{"maneuver": {"name": "jog"}}], tmp_path_factory.mktemp("log"))[0]


@pytest.mark.parametrize(
    "words",
    [
        "log plot LOG -o a.mcap", "log plot LOG -o a.yaml", "log plot LOG -o .", "log diff LOG LOG -o a.mcap", "log export LOG -o a.mcap",
        "design force_axis -o a.mcap", "paper -o a.yaml", "live --layout a.yaml",
    ],
)  # fmt: skip
def test_another_kind_of_file_is_refused(
    words: str, log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a.mcap", "a.yaml"):
        Path(name).write_bytes(MINE)
    with pytest.raises(SystemExit) as refused:
        main([str(log) if word == "LOG" else word for word in words.split()])
    assert refused.value.code == 2
    assert ": nearest is " in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a.mcap": MINE, "a.yaml": MINE}


def test_an_export_does_not_replace_the_measurement(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = log.with_suffix(".csv")
    table.write_bytes(MINE)
    assert main(["log", "export", str(log)]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == f"next: longreach log export {log} -o {log.with_name(log.stem + '-2.csv')}"
    assert table.read_bytes() == MINE


def test_a_design_does_not_replace_a_rig_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = tmp_path / "mine.yaml"
    rig.write_bytes(MINE)
    assert main(["design", "force_axis", "-o", str(rig)]) == 2
    assert f"-o {tmp_path / 'mine-2.yaml'}" in capsys.readouterr().err
    assert rig.read_bytes() == MINE


def test_a_search_refuses_at_once_what_it_could_not_write(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its own rig file as the improved one, a file for a folder, a request that is none: not after minutes."""
    rig = tmp_path / "rig.yaml"
    rig.write_text(find("rigs", "ornl_testbed").read_text())
    words = ["gap", "find", "--rig", str(rig), "--log", str(log), "--holdout", str(log)]
    assert main([*words, "--out", str(tmp_path)]) == 2
    assert "written over" in capsys.readouterr().err
    assert main([*words, "--out", str(rig)]) == 1
    assert "A file stands where a folder is needed" in capsys.readouterr().err
    assert main([*words, "--out", str(tmp_path / "found"), "--request", str(tmp_path / "nosuch.yaml")]) != 0
    assert "nosuch.yaml" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["rig.yaml"]
