"""`identify` and `shape` as a rig engineer types them: runs, record, a rig file that refers to it, a recommendation from it."""

from __future__ import annotations

import datetime
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from config.loading.calibration_record import load_record
from config.loading.load import apply_overrides, find, load_rig
from daemon.cli.main import main
from daemon.lockstep import run_lockstep
from recording.evaluation.replay import reexecute
from recording.evaluation.vibration import hold_vibration, rms_mps2
from recording.files.reader import read_log
from tuning.identification.identification import Identification, LinkFound
from tuning.identification.identify_plots import summary
from tuning.link_and_payload.link_map import LinkMap, MapPoint
from tuning.link_and_payload.payload import PayloadEstimate

POUND = 0.45359237


def _answer(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    assert main([*words, "--json"]) == 0
    answer: dict[str, Any] = json.loads(capsys.readouterr().out)
    return answer


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The link at three extensions with 30 lb, which the rig file believes as well."""
    directory = tmp_path_factory.mktemp("identified")
    words = ["identify", "--what", "map", "--extensions", "30 in, 42 in, 54 in", "--payloads", "30 lb", "--by", "tester", "--out"]
    assert main([*words, str(directory)]) == 0
    return directory


def _record(out: Path) -> Path:
    (record,) = out.glob("*.yaml")
    return record


@pytest.mark.slow
def test_the_record_says_who_when_how_sure_and_from_which_logs(out: Path) -> None:
    record = load_record(_record(out))
    assert (record.by, record.source, record.rig) == ("tester", "simulated", "ornl_testbed")
    assert (record.valid_until - record.identified_on).days == 180
    assert set(record.logs) == {path.name for path in (out / "logs").glob("*.mcap")}
    assert record.link is not None
    assert record.link.payload_kg == pytest.approx(30 * POUND, rel=0.01)
    assert abs(record.link.payload_kg - 30 * POUND) < record.link.payload_uncertainty_kg < 0.02 * 30 * POUND
    assert [point.extension_m for point in record.link.frequency_map] == pytest.approx([30 * 0.0254, 42 * 0.0254, 54 * 0.0254], abs=1e-3)


@pytest.mark.slow
def test_the_map_is_that_of_the_beam_with_a_joint_that_gives(out: Path) -> None:
    """Clamped one-shape formula with 30 lb, 0.7 %, with the shipped end-point feedback on; damping of the plant, 0.5 %."""
    numbers = json.loads((out / "results.json").read_text())["links"][0]
    for point in numbers["map"]:
        length = point["extension_m"]
        clamped = np.sqrt(3 * 3556.75 / (length**3 * (30 * POUND + 33 / 140 * 2.545698 * length))) / (2 * np.pi)
        assert point["clamped_Hz"] == pytest.approx(clamped, rel=0.007)
        assert point["damping_ratio"] == pytest.approx(0.005, abs=0.002)
    assert abs(numbers["damping_ratio"] - 0.005) < numbers["damping_uncertainty"] < 0.002


@pytest.mark.slow
def test_pictures_and_page_are_written_whole(out: Path) -> None:
    assert (out / "link.png").read_bytes().startswith(b"\x89PNG")
    assert (out / "index.html").read_text().count("data:image/png") == 1
    assert not list(out.glob(".*.part"))


@pytest.mark.slow
def test_the_same_logs_give_the_same_record(out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    logs = [word for path in sorted((out / "logs").glob("*.mcap")) for word in ("--log", str(path))]
    _answer(capsys, "identify", *logs, "--out", str(tmp_path))
    old, new = load_record(_record(out)), load_record(_record(tmp_path))
    assert new.source == "logs"
    assert (new.link, new.logs) == (old.link, old.logs)


@pytest.mark.slow
def test_a_rig_file_takes_the_numbers_and_check_shows_them(out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = tmp_path / "rig.yaml"
    rig.write_text(find("rigs", "ornl_testbed").read_text() + f"\nidentified: {{record: {_record(out)}}}\n")
    link = load_rig(rig).rig.link_mode
    assert link is not None
    assert link.payload_kg == pytest.approx(30 * POUND, rel=0.01)
    assert len(link.frequency_map) == 3
    answer = _answer(capsys, "check", str(rig))
    assert any("identified" in finding["text"] and "tester" in finding["text"] for finding in answer["findings"])


def test_a_single_axis_is_identified_from_its_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No link, no oil, no extension: a response and its fit remain. Runs of its own are refused with the way round."""
    wave = "from: 0.5 Hz\nto: 10 Hz\nperiod: 2 s\nperiods: 3\nlines: 8\ncrest_limit: 3\n"
    text = f'longreach: maneuver/1\nname: waves\nkind: multisine\njoint: axis\n"on": command\namplitude: 0.3 V\n{wave}'
    (log,) = run_lockstep(load_rig("force_axis"), [{"maneuver": {"text": text, "name": "waves"}}], tmp_path)
    answer = _answer(capsys, "identify", "--log", str(log), "--out", str(tmp_path))
    assert [response["conditions"]["joint"] for response in answer["responses"]] == ["axis"]
    assert (answer["links"], answer["responses"][0]["conditions"]["extension_m"]) == ([], None)
    assert load_record(Path(answer["record"])).joints[0].extension_m is None
    assert main(["identify", "--log", str(log), "--out", str(tmp_path / "told")]) == 0
    told = capsys.readouterr().out
    for number in (r"velocity gain \S+ m/s/V ±", r"lag \S+ s ±", r"gain \S+ m/s\^3/V ±", r"damping \S+ 1/s ±", r"stiffness \S+ 1/s\^2 ±"):
        assert re.search(f", {number}", told) or re.search(f"; {number}", told), told
    assert main(["identify", "force_axis", "--out", str(tmp_path)]) == 1
    assert "longreach identify --log" in capsys.readouterr().err
    record = Path(answer["record"])
    record.write_text("mine")
    assert main(["identify", "--log", str(log), "--out", str(tmp_path)]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == f"next: longreach identify --log {log} --out {tmp_path}-2"
    assert record.read_text() == "mine"


def test_a_record_of_the_same_day_is_refused_before_any_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = tmp_path / f"ornl_testbed-{datetime.date.today()}.yaml"
    record.write_text("mine")
    assert main(["identify", "--what", "payload", "--out", str(tmp_path)]) == 2
    assert "the calibration record exists already" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == [record.name], "no log: nothing has run"


def test_the_summary_is_in_the_units_of_the_rig_file_and_leaves_out_what_was_not_seen() -> None:
    """One move tells the link's frequency, not its damping."""
    testbed = load_rig("ornl_testbed")
    point = MapPoint(0.9144, np.nan, 4.104, np.nan, 0.004, 4.107, np.nan, 0)
    payload = PayloadEstimate(45.1 * POUND, 0.2 * POUND, "balance", 9000)
    link = LinkFound(45 * POUND, (payload,), LinkMap((point,), np.nan, np.nan, 1.001, np.nan), "")
    lines = summary(Identification(testbed.rig, testbed.text, links=[link]))
    assert lines[:2] == [
        "payload 45.1 ± 0.2006 lb by balance (rig file 45 lb)",
        "  36 in: link alone 4.104 ± 0.008 Hz (rig file 4.107)",
    ]
    assert "identify --what map" in lines[2]
    assert "nan" not in "".join(lines)
    assert "20.457 ± 0.091 kg" in summary(Identification(testbed.rig, testbed.text, links=[link]), si=True)[0]


@pytest.mark.slow
def test_shape_recommends_from_the_record(out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("shape", "--maneuver", "joint_steps", "--error", "5", "--allowed", "0.2 m/s^2", "-o", str(tmp_path / "shape.png"))
    believed, identified = _answer(capsys, *words, "--ideal"), _answer(capsys, *words, "--record", str(_record(out)))
    assert (tmp_path / "shape.png").read_bytes().startswith(b"\x89PNG")
    for answer in (believed, identified):
        filters = {each["kind"]: each for each in answer["filters"]}
        judged = filters[answer["chosen"]]["coupled"] or filters[answer["chosen"]]["ideal"]
        assert judged["worst_mps2"] <= 0.2
        assert len(filters["zvd"]["ideal"]["by_error"]) == 9
    assert filters["none"]["tip"]["speed_mps"] == filters["none"]["tip"]["planned_speed_mps"] > 0.0
    assert filters["zvd"]["coupled"]["errors"] == pytest.approx([-0.05, 0.0, 0.05])
    late = {
        name: next(each["ideal"]["late_s"] for each in answer["filters"] if each["kind"] == "zvd")
        for name, answer in (("45 lb", believed), ("30 lb", identified))
    }
    assert late["30 lb"] < late["45 lb"]  # a lighter tip swings faster, so the filter is shorter


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--amplitudes", "1 m"), "--amplitudes is a list of quantities in V"),
        (("--joint", "elbow"), "unknown joint"),
        (("--band", "5 Hz, 1 Hz"), "--band '1 Hz, 5 Hz'"),
        (("--band", "0 Hz, 5 Hz"), "--band: no band: 0 Hz, 5 Hz. Write the lower frequency first, above 0."),
        (("--on-rig", "--payloads", "0 lb"), "cannot be set by command"),
        (("--log", "nothing.mcap"), "the log cannot be opened"),
    ],
)
def test_what_cannot_be_is_refused(words: tuple[str, ...], text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["identify", *words, "--out", str(tmp_path)]) in (2, 3)
    assert text in capsys.readouterr().err


@pytest.mark.slow
def test_an_unknown_payload_is_found_and_the_filter_made_for_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """30 lb at the tip of an arm whose rig file says 45 lb: identified, the adaptive filter leaves half as much. (Without end-point
    feedback; with it both leave less than 0.05 m/s², whatever the filter is made for.)"""
    alone = ["end_point.gain=0", "servo.rotary.gain=0.35 V/deg"]
    text = apply_overrides(load_rig("ornl_testbed").text, ["plant.link.payload=30 lb", *alone])
    (tmp_path / "rig.yaml").write_text(text)
    answer = _answer(capsys, "identify", str(tmp_path / "rig.yaml"), "--what", "map", "--out", str(tmp_path / "found"))
    assert answer["links"][0]["payload"][0]["payload_kg"] == pytest.approx(30 * POUND, rel=0.01)
    (tmp_path / "identified.yaml").write_text(f"{text}\nidentified: {{record: {answer['record']}}}\n")
    request = {"maneuver": {"name": "paper_line"}, "shaper": {"kind": "adaptive"}, "approach": True}
    logs = {name: run_lockstep(load_rig(tmp_path / name), [request], tmp_path / "logs")[0] for name in ("rig.yaml", "identified.yaml")}
    left = {name: rms_mps2(hold_vibration(read_log(log))) for name, log in logs.items()}
    assert left["identified.yaml"] < 0.7 * left["rig.yaml"]
    assert reexecute(logs["identified.yaml"]).identical


@pytest.mark.slow
def test_eq_4_from_a_retracted_unloaded_arm(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The conditions under which the paper must have identified it: velocity gain 39.2 °/s/V, lag 22.8 ms, at the level of 0.3 V."""
    words = [
        "identify",
        "--what",
        "multisine",
        "--payloads",
        "0 lb",
        "--extensions",
        "14 in",
        "--amplitudes",
        "0.6 V",
        "--out",
        str(tmp_path),
    ]
    answer = _answer(capsys, *words)
    (response,) = answer["responses"]
    fit = response["fit"]
    assert np.degrees(fit["velocity_gain"]) == pytest.approx(39.16, rel=0.08)
    assert fit["damping"] / fit["stiffness"] == pytest.approx(140 / 6150, rel=0.25)
    assert fit["worst_dB"] < 2.0
    assert np.median(response["odd"]["level_dB"]) > np.median(response["even"]["level_dB"]) + 10  # friction is odd
    joints = yaml.safe_load(_record(tmp_path).read_text())["joints"]
    assert joints[0]["stiffness"] == pytest.approx(fit["stiffness"], rel=1e-6)
