"""What a user sees of a log: info, check, CSV, pictures, viewer layout."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from config.errors import LogError, UsageError
from config.loading.load import load_rig
from recording.evaluation.plots import plot_log, vibration_plot
from recording.files.check import check_log
from recording.files.export import export
from recording.files.foxglove import foxglove_layout
from recording.files.info import describe
from recording.files.reader import open_rig, read_log
from recording.files.writer import LogWriter
from recording.format.event import Event
from recording.format.layout import CycleLayout
from recording.importing.ingest import ingest
from servo_control.signals import Mode
from tests.support.measured_data import EMPS
from tests.support.recording import logs, session


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return session.recorded_run(tmp_path_factory.mktemp("reports") / "run.mcap", ring_mps2={0: 1.0, 2: 1.0, 4: 1.0})


def altered(tmp_path: Path, change: dict[str, object]) -> Path:
    """A log of 100 cycles in which columns are set as given (arrays or numbers)."""
    layout = CycleLayout(logs.JOINTS)
    table = np.array(logs.rows(layout, 100))
    for name, values in change.items():
        table[:, layout.index(name)] = values
    integers = [k for k, field in enumerate(layout.fields) if field.ros_type != "float64"]
    writer = LogWriter(tmp_path / "a.mcap", layout, {}, logs.metadata())
    for k, row in enumerate(table.tolist()):
        writer.cycle(k, layout.pack([int(value) if number in integers else value for number, value in enumerate(row)]))
    writer.close({})
    return tmp_path / "a.mcap"


def finding(path: Path, name: str) -> tuple[str, str]:
    return next((found.grade, found.text) for found in check_log(path).findings if found.name == name)


def test_info_of_a_run(run: Path) -> None:
    facts = describe(read_log(run))
    assert (facts.rig_name, facts.kind, facts.complete) == ("ornl_testbed", "recorded", True)
    assert facts.rate_Hz == pytest.approx(1000.0)
    assert [(r.number, r.maneuver, r.shaper, r.valid) for r in facts.runs] == [(1, "paper_line", "none", True)]
    text = facts.text()
    assert "run 1: paper_line, shaper none, from t = 0.110 s for 18.300 s, valid" in text
    assert "late p50/p99/max, us: 13/16/16" in text
    assert "grade: A" in text
    assert "prismatic.return_pressure_Pa" not in text  # not fitted in this recording


def test_info_shows_the_whole_passport_to_programs_and_its_gist_to_people(tmp_path: Path) -> None:
    layout = CycleLayout(("axis",))
    writer = LogWriter(tmp_path / "a.mcap", layout, {}, logs.metadata())
    row = layout.blank()
    row[layout.index("reservoir_temperature_C")] = 40.0
    writer.cycle(0, layout.pack(row))
    writer.close({"grade": "B", "late_us_p99": "12", "late_histogram": "1 0 0", "ended_by": "disarmed"})
    facts = describe(read_log(tmp_path / "a.mcap"))
    assert facts.passport["late_histogram"] == "1 0 0"
    assert facts.fitted == ("reservoir_temperature_C",)
    assert "grade: B\n  ended_by: disarmed\n" in facts.text()
    assert "histogram" not in facts.text()


@pytest.mark.parametrize(
    ("mode", "reason"), [(Mode.STOPPING, "stopped"), (Mode.FAULT, "fault"), (None, "the log ends before the run does")]
)
def test_runs_that_did_not_end_well_are_not_valid(tmp_path: Path, mode: Mode | None, reason: str) -> None:
    recording = session.Session(tmp_path / "a.mcap")
    recording.position = [0.0, 40 * 0.0254]
    recording.cycles(Mode.HOLDING, 10)
    recording.start(recording.plan("paper_line", 1))
    recording.cycles(Mode.RUNNING, 200)
    if mode is not None:
        recording.cycles(mode, 5)
    facts = describe(read_log(recording.close()))
    assert f"not valid: {reason}" in facts.text()


def test_a_run_that_goes_on_is_not_told_as_one_that_was_cut(tmp_path: Path) -> None:
    """A log that is being recorded, as another process reads it."""
    recording = session.Session(tmp_path / "a.mcap")
    recording.position = [0.0, 40 * 0.0254]
    recording.start(recording.plan("paper_line", 1))
    recording.cycles(Mode.RUNNING, 200)
    recording.writer.flush()
    text = describe(read_log(recording.path)).text()
    recording.close()
    assert "The log is still being recorded, or was cut at t = 0.199 s" in text
    assert "not valid: the run still goes on, or the log was cut" in text


@pytest.mark.parametrize(
    ("text", "valid", "reason"),
    [("run 1: valid", 1.0, ""), ("run 1: invalid, because 7 % of its periods were missed", 0.0, "7 % of its periods were missed")],
)
def test_the_verdict_shown_is_the_daemons(tmp_path: Path, text: str, valid: float, reason: str) -> None:
    recording = session.Session(tmp_path / "a.mcap")
    recording.position = [0.0, 40 * 0.0254]
    recording.cycles(Mode.HOLDING, 10)
    recording.start(recording.plan("paper_line", 1))
    recording.cycles(Mode.RUNNING, 200)
    recording.cycles(Mode.HOLDING, 5)
    recording.writer.event(session.START_NS, Event(215, 0.215, 20, "run_ended", text, {"run": 1.0, "valid": valid}))
    assert describe(read_log(recording.close())).runs[0].reason == reason


def test_check_of_a_good_log(run: Path) -> None:
    log = check_log(run, load_rig("ornl_testbed").rig)
    grades = {found.name: found.grade for found in log.findings if found.name != "signals"}
    assert set(grades.values()) == {"ok"}
    assert set(grades) == {"whole", "attachments", "runs", "cycles", "time", "drops", "timing", "rig"}


def test_check_finds_what_is_wrong(tmp_path: Path) -> None:
    cycle = np.arange(100.0)
    cycle[60:] += 5
    t = np.arange(100) * 1e-3
    t[80] = t[79]
    position = np.zeros(100)
    position[10:] = np.nan
    # Columns count since the loop's start: 7 drops and an overrun belong to recordings before this one.
    drops, overruns = np.where(cycle < 50, 7, 12), np.where(cycle < 50, 1, 3)
    path = altered(tmp_path, {"cycle": cycle, "t_s": t, "drops": drops, "overruns": overruns, "rotary.position": position, "maneuver": 3})
    assert finding(path, "whole")[0] == "ok"
    assert finding(path, "cycles") == ("error", "5 cycles missing in 1 places, first after cycle 59 at t = 0.059 s")
    assert finding(path, "time") == ("error", "time does not increase at row 80: 0.079 s, then 0.079 s")
    assert finding(path, "drops") == ("error", "5 records did not reach the log")
    assert finding(path, "runs") == ("error", "missing: run-3.json, maneuver-3.yaml")
    assert finding(path, "attachments")[1].startswith("missing: rig.yaml, calibration.json, foxglove_layout.json, controller_state.json;")
    assert finding(path, "signals") == ("error", "NaN (sensor not fitted or failed) while armed: rotary.position in 90 of 100 rows")
    report = check_log(path)
    assert not report.good
    assert report.text().startswith(f"{path}: not good\n")


def test_a_few_lost_samples_and_skipped_periods_are_warnings(tmp_path: Path) -> None:
    t = np.arange(100) * 1e-3
    t[50:] += 3e-3
    position = np.zeros(100)
    position[10] = np.nan
    path = altered(tmp_path, {"t_s": t, "rotary.position": position})
    assert finding(path, "signals")[0] == "warning"
    assert finding(path, "time") == ("warning", "0.102 s, median period 1 ms, 3 periods skipped")


def test_short_steps_make_up_for_no_skipped_period(tmp_path: Path) -> None:
    """Three stamps in a burst after a pause, as a coarse clock gives them."""
    t = np.arange(100) * 1e-3
    t[50:] += 3e-3
    t[50:54] = t[50] + 1e-5 * np.arange(4)
    t[54:] -= 3e-3
    assert finding(altered(tmp_path, {"t_s": t}), "time") == ("warning", "0.099 s, median period 1 ms, 3 periods skipped")


def test_check_of_a_cut_log_and_of_another_rig(run: Path, tmp_path: Path) -> None:
    (tmp_path / "cut.mcap").write_bytes(run.read_bytes()[:-4000])
    grade, text = finding(tmp_path / "cut.mcap", "whole")
    assert grade == "error"
    assert text.startswith("The log is still being recorded, or was cut at t = ")
    other = check_log(run, load_rig("force_axis").rig)
    assert not other.good
    assert other.findings[-1].text == (
        "the log is of rig ornl_testbed with joints rotary, prismatic; the rig given is force_axis with joints axis"
    )


def test_csv_keeps_every_bit_and_comes_back(run: Path, tmp_path: Path) -> None:
    log = read_log(run)
    assert export(log, tmp_path / "a.csv", ["rotary.position", "rotary.command_V", "mode"]) == log.cycles
    with (tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["t_s", "rotary.position", "rotary.command_V", "mode"]
    assert np.array_equal([float(row["rotary.command_V"]) for row in rows], log.columns["rotary.command_V"])
    assert rows[40]["mode"] == "2"
    ingest(tmp_path / "a.csv", None, tmp_path / "b.mcap")
    again = read_log(tmp_path / "b.mcap")
    assert np.array_equal(again.columns["rotary.position"], log.columns["rotary.position"])
    assert np.array_equal(again.columns["mode"], log.columns["mode"])


def test_a_whole_export_has_every_column(tmp_path: Path) -> None:
    logs.write(tmp_path / "a.mcap", 20)
    export(read_log(tmp_path / "a.mcap"), tmp_path / "a.csv")
    with (tmp_path / "a.csv").open() as file:
        header, first = next(csv.reader(file)), file.readline()
    assert set(header) == {field.name for field in CycleLayout(logs.JOINTS).fields}
    assert "nan" in first  # not fitted


def test_export_refuses_a_wrong_column(run: Path, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"the log has no column 'rotary.comand_V': nearest is 'rotary.command_V'"):
        export(read_log(run), tmp_path / "a.csv", ["rotary.comand_V"])
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "no_folder").touch()
    with pytest.raises(LogError, match="the table cannot be written"):
        export(read_log(run), tmp_path / "no_folder" / "a.csv", ["mode"])
    assert [path.name for path in tmp_path.iterdir()] == ["no_folder"]


def test_names_that_matlab_cannot_keep_apart_or_whole_are_refused(run: Path, tmp_path: Path) -> None:
    log = read_log(run)
    twice, long = "rotary_position", "rotary." + "x" * 57
    for columns, text in (
        (["rotary.position", twice], "columns would have one name in MATLAB: rotary.position, rotary_position. Choose other columns"),
        ([long], f"names are too long for MATLAB: {long} (limit: 63 characters). Choose other columns with --columns"),
    ):
        widened = replace(log, columns=log.columns | dict.fromkeys((twice, long), log.columns["t_s"]))
        with pytest.raises(LogError) as caught:
            export(widened, tmp_path / "a.mat", columns)
        assert text in str(caught.value)
    assert not list(tmp_path.iterdir())
    assert export(log, tmp_path / "a.mat") == log.cycles


def inked(path: Path) -> float:
    """Share of the picture that is not white."""
    return float(np.mean(np.any(imread(path)[:, :, :3] < 0.98, axis=2)))


def test_pictures(run: Path, tmp_path: Path) -> None:
    log = read_log(run)
    plot_log(log, tmp_path / "log.png")
    vibration_plot([log, log], ["unshaped", "shaped"], tmp_path / "tip.png")
    for name in ("log.png", "tip.png"):
        assert imread(tmp_path / name).shape[:2] == (990, 1760)
        assert 0.02 < inked(tmp_path / name) < 0.4


@pytest.mark.skipif(not EMPS.is_dir(), reason="the measured EMPS data (../shared/data/emps) are not here")
def test_imported_data_can_be_described_checked_and_plotted(tmp_path: Path) -> None:
    ingest(EMPS / "emps_estimation.csv", "emps", tmp_path / "a.mcap", load_rig("force_axis"))
    log = read_log(tmp_path / "a.mcap")
    assert open_rig(log).name == "force_axis"
    text = describe(log).text()
    assert "imported log of rig force_axis, joints axis\n  24841 cycles, 24.840 s at 1000 Hz" in text
    assert "columns with numbers: axis.target, axis.reference, axis.position, axis.command_V\n" in text
    assert finding(tmp_path / "a.mcap", "attachments")[1] == "data of another system, imported from emps_estimation.csv"
    plot_log(log, tmp_path / "a.png")
    assert inked(tmp_path / "a.png") > 0.02
    with pytest.raises(LogError, match="the log has no tip acceleration"):
        vibration_plot([log], ["emps"], tmp_path / "b.png")


def test_events_are_counted(tmp_path: Path) -> None:
    layout = CycleLayout(("axis",))
    writer = LogWriter(tmp_path / "a.mcap", layout, {}, logs.metadata())
    writer.cycle(0, layout.pack(layout.blank()))
    for level in (20, 20, 30, 77):
        writer.event(0, Event(0, 0.0, level, "x", "y"))
    writer.close({})
    assert describe(read_log(tmp_path / "a.mcap")).events == {"info": 2, "warning": 1, "77": 1}


def test_the_viewer_layout_names_fields_that_exist() -> None:
    layout = CycleLayout(logs.JOINTS)
    content = json.loads(foxglove_layout(layout))
    wire_names = {field.name.lower() for field in layout.fields}
    paths = [path["value"] for panel in content["configById"].values() for path in panel.get("paths", [])]
    assert len(paths) > 15
    assert {path.removeprefix("/cycle.") for path in paths} <= wire_names
    placed = json.dumps(content["layout"])
    assert all(panel in placed for panel in content["configById"])
