"""`runs`, `log diff` and `log plot --signals`, as typed."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from config.loading.load import load_rig
from daemon.cli.main import main
from daemon.lockstep import run_lockstep
from recording.evaluation import kept_vibration
from recording.evaluation.kept_vibration import residual_vibration
from recording.evaluation.vibration import hold_vibration, rms_mps2
from recording.files.catalogue import recorded
from recording.files.info import run_facts
from recording.files.reader import read_log
from recording.files.recover import recover
from tests.support.recording import session


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of the daemon's loop, one of its own making that rings, and a log that was cut."""
    place = tmp_path_factory.mktemp("logs")
    jogs = run_lockstep(load_rig("ornl_testbed"), [{"maneuver": {"name": "jog"}}], place)
    session.recorded_run(place / "ring.mcap", ring_mps2={0: 2.8, 2: 2.7, 4: 3.6})
    (place / "cut.mcap").write_bytes(jogs[0].read_bytes()[: jogs[0].stat().st_size // 2])
    return place


def listed(capsys: pytest.CaptureFixture[str], *words: str) -> list[dict[str, object]]:
    assert main(["runs", *words, "--json"]) == 0
    found: list[dict[str, object]] = json.loads(capsys.readouterr().out)
    return found


def test_the_end_of_a_file_says_what_its_rows_say(folder: Path) -> None:
    path = next(folder.glob("ornl*.mcap"))
    (fast,), (whole,) = recorded(path).runs, run_facts(read_log(path))
    assert (fast.number, fast.maneuver, fast.shaper, fast.valid, fast.reason) == (1, "jog", "none", True, "")
    assert (fast.number, fast.maneuver, fast.shaper, fast.valid) == (whole.number, whole.maneuver, whole.shaper, whole.valid)
    assert fast.start_t_s == pytest.approx(whole.start_t_s, abs=1e-9)
    assert fast.duration_s == pytest.approx(whole.duration_s, abs=1.5e-3)
    log = read_log(path)
    row = int((log.columns["mode"] == 3).argmax())
    assert recorded(path).begun[1].timestamp() == pytest.approx(log.time_ns[row] * 1e-9, abs=1e-6)


def test_a_run_that_a_recovered_log_breaks_off_lasts_up_to_its_last_cycle(folder: Path, tmp_path: Path) -> None:
    recover(folder / "cut.mcap", tmp_path / "repaired.mcap")
    (fast,), (whole,) = recorded(tmp_path / "repaired.mcap").runs, run_facts(read_log(tmp_path / "repaired.mcap"))
    assert whole.duration_s > 0.1
    assert fast.duration_s == pytest.approx(whole.duration_s, abs=1.5e-3)


def test_a_valid_run_whose_log_was_damaged_and_recovered_says_so(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The daemon's verdict stands in the log, and cycles of the run do not."""
    path = next(folder.glob("ornl*.mcap"))
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    (tmp_path / "damaged.mcap").write_bytes(data)
    assert recover(tmp_path / "damaged.mcap", tmp_path / "repaired.mcap").missing_cycles > 0
    assert main(["runs", str(tmp_path / "repaired.mcap"), str(path)]) == 0
    assert sorted(line.rpartition("  ")[2] for line in capsys.readouterr().out.splitlines()[::2]) == ["valid", "valid, in a recovered log"]


def test_the_end_is_read_and_not_the_cycles(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(path: Path) -> None:
        raise AssertionError(f"{path} was read whole")

    monkeypatch.setattr("recording.files.catalogue.read_log", never)
    assert len(recorded(next(folder.glob("ornl*.mcap"))).runs) == 1


def test_runs_are_filtered(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = str(folder)
    assert {(each["maneuver"], each["valid"]) for each in listed(capsys, place)} == {("jog", True), ("jog", False), ("paper_line", True)}
    assert [each["maneuver"] for each in listed(capsys, place, "--maneuver", "paper*")] == ["paper_line"]
    assert [Path(str(each["log"])).name for each in listed(capsys, place, "--invalid")] == ["cut.mcap"]
    assert listed(capsys, place, "--rig", "force*") == []
    assert {each["maneuver"] for each in listed(capsys, place, "--until", "2000-01-01")} == {"jog"}
    assert {each["maneuver"] for each in listed(capsys, place, "--since", "2000-01-02")} == {"paper_line"}
    assert len(listed(capsys, place, "--last", "1")) == 1


def test_where_no_run_is_left_the_option_that_left_none_is_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["runs", str(folder), "--maneuver", "jgo"]) == 0
    assert capsys.readouterr().out == "3 runs, none with --maneuver jgo (there are: jog, paper_line)\n"
    assert main(["runs", str(folder), "--maneuver", "paper*", "--invalid"]) == 0
    assert capsys.readouterr().out == "3 runs, none of which all options allow\n"


def test_residual_vibration_is_measured_once_a_log(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = rms_mps2(hold_vibration(read_log(folder / "ring.mcap")))
    (found,) = listed(capsys, str(folder), "--vibration-above", "2")
    assert found["vibration_mps2"] == pytest.approx(expected)
    assert listed(capsys, str(folder), "--maneuver", "paper*", "--vibration-below", "2") == []

    def never(path: Path) -> dict[int, float]:
        raise AssertionError(f"{path} was measured again")

    monkeypatch.setattr(kept_vibration, "_measured", never)
    assert residual_vibration([folder / "ring.mcap"])[folder / "ring.mcap"] == {1: pytest.approx(expected)}
    (folder / kept_vibration.KEPT).write_text("[broken")
    with pytest.raises(AssertionError, match="measured again"):
        residual_vibration([folder / "ring.mcap"])


def test_a_file_that_is_no_log_is_told_and_a_wrong_date_or_folder_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "no.mcap").write_bytes(b"no log")
    assert main(["runs", str(tmp_path)]) == 0
    assert "not a log" in capsys.readouterr().err
    assert main(["runs", str(folder), "--since", "yesterday"]) == 2


@pytest.mark.parametrize("words", [["runs"], ["log", "recover", "--all"], ["log", "report", "--all"]])
@pytest.mark.parametrize("error", [FileNotFoundError(2, "No such file or directory"), PermissionError(13, "Permission denied")])
def test_a_folder_that_cannot_be_read_is_no_empty_one(
    words: list[str], error: OSError, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Root may look into every folder, so the refusal is put in."""

    def refused(_: object) -> None:
        raise error

    monkeypatch.setattr("recording.files.recordings.os.scandir", refused)
    monkeypatch.setattr("os.nice", lambda _: None)
    assert main([*words, str(tmp_path)]) == 3
    assert f"{tmp_path}: the folder of logs cannot be read: {error.strerror}" in capsys.readouterr().err


def test_diff_says_what_differs_with_a_picture(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a, b, picture = tmp_path / "a.mcap", tmp_path / "b.mcap", tmp_path / "d.png"
    shutil.copy(next(folder.glob("ornl*.mcap")), a)
    shutil.copy(a, b)
    assert main(["log", "diff", str(a), str(b), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["picture"] is None
    assert main(["log", "diff", str(a), str(folder / "cut.mcap")]) == 1
    assert "not valid: the run still goes on, or the log was cut" in capsys.readouterr().out
    assert main(["log", "diff", str(a), str(folder / "ring.mcap"), "-o", str(picture), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert ("maneuver", "name") in {(each["about"], each["key"]) for each in found["changed"]}
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_plot_of_chosen_signals(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "p.png"
    words = ["log", "plot", str(folder / "ring.mcap"), "--signals", "rotary.*", "--from", "1", "--to", "2", "-o", str(picture), "--json"]
    assert main(words) == 0
    signals = json.loads(capsys.readouterr().out)["signals"]
    assert "rotary.position" in signals
    assert not any(name.endswith("_raw") or name.startswith("prismatic") for name in signals)
    assert picture.read_bytes().startswith(b"\x89PNG")
