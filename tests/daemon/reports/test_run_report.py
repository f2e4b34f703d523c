"""The page of a run: complete, self-contained, with numbers that agree with the log and with the same run simulated again."""

from __future__ import annotations

import dataclasses
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from config.errors import LogError, UsageError
from config.loading.load import load_rig
from daemon.cli.main import main
from daemon.lockstep import run_lockstep
from daemon.reports.earlier_run import last_valid_run
from daemon.reports.missing_pages import watch
from daemon.reports.run_report import run_page, write_reports
from daemon.reports.simulated_run import simulated_run
from daemon.reports.trace import Trace
from recording.evaluation.vibration import hold_vibration
from recording.files.catalogue import recorded
from recording.files.reader import Log, open_rig, read_log
from recording.files.scan import MAGIC
from tests.support.daemon.rigs import simple_rig
from tests.support.recording import session
from tests.support.static_page import opened, outside_links

REQUEST = {"maneuver": {"name": "paper_line"}, "shaper": {"kind": "zvd"}, "approach": True}


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The same maneuver twice, unshaped and shaped, one after the other."""
    return run_lockstep(load_rig("ornl_testbed"), [{**REQUEST, "shaper": {"kind": "none"}}, REQUEST], tmp_path_factory.mktemp("runs"))


@pytest.fixture(scope="module")
def page(logs: list[Path]) -> Path:
    said: list[str] = []
    (made,) = write_reports(logs[1], say=said.append)
    assert said == ["making the report of run 2", "running it again on the simulated rig of the log", "drawing"]
    return made


@pytest.fixture(scope="module")
def simulated(logs: list[Path]) -> Log:
    return simulated_run(read_log(logs[1]), 2)


@pytest.mark.slow
def test_time_is_0_where_the_program_begins_with_and_without_an_approach(tmp_path: Path) -> None:
    """The arm stands 40 mm away before the first run and at the program's start before the second one."""
    away = {"maneuver": {"name": "jog", "parameters": {"joint": "prismatic", "by": "40 mm"}}}
    line = {"maneuver": {"name": "paper_line"}, "shaper": {"kind": "none"}, "approach": True}
    *_, first, second = run_lockstep(load_rig("ornl_testbed"), [away, line, line], tmp_path)
    traces = [Trace("", read_log(log), number, {}) for number, log in ((2, first), (3, second))]
    assert [trace.plan is not None and trace.plan.segments[0].name for trace in traces] == ["approach", "move 1"]
    for joint in ("rotary", "prismatic"):
        lines = [trace.line(f"{joint}.target") for trace in traces]
        assert lines[0] is not None
        assert lines[1] is not None
        when = np.arange(0.0, 18.0, 0.1)
        targets = [np.interp(when, line.x, line.y) for line in lines if line is not None]
        np.testing.assert_allclose(targets[0], targets[1], atol=1e-3)  # it begins where the arm stands


@pytest.mark.slow
def test_the_simulated_run_is_that_of_the_log(logs: list[Path], simulated: Log) -> None:
    """Both are the same controller and plant; they differ by what the oil and the joints did before, and by the sensors' noise."""
    again, measured = hold_vibration(simulated), hold_vibration(read_log(logs[1]))
    assert [hold.move for hold in again] == [hold.move for hold in measured]
    assert [hold.amplitude_mps2 for hold in again] == pytest.approx([hold.amplitude_mps2 for hold in measured], abs=0.02)


@pytest.mark.slow
def test_a_rig_with_real_devices_is_simulated_without_them(logs: list[Path], simulated: Log) -> None:
    """The log as the testbed on real buses would have written it: same arm, other devices."""
    log = read_log(logs[1])
    on_buses = {**log.attachments, "rig.yaml": load_rig("ornl_testbed_can").text.encode()}
    again = simulated_run(dataclasses.replace(log, attachments=on_buses), 2)
    assert {device.driver for device in open_rig(again).devices.values()} == {"sim"}
    assert open_rig(again).signals["rotary.position"].calibration.scale == pytest.approx(np.radians(0.005))
    np.testing.assert_array_equal(again.columns["rotary.position"], simulated.columns["rotary.position"])


@pytest.mark.slow
def test_the_page_says_what_the_log_says(page: Path, logs: list[Path]) -> None:
    text = page.read_text()
    for hold in hold_vibration(read_log(logs[1])):
        assert f"<td>{hold.move}</td><td>{hold.amplitude_mps2:.3f}</td>" in text
    assert "<b>valid</b>" in text
    assert f"Last valid run of paper_line: {logs[0].name}, run 1." in text
    for heading in ("Vibration left", "Joints", "Tip", "Spectra in the holds", "Pressures and temperatures", "Timing", "Events"):
        assert f"<h2>{heading}" in text, heading
    assert {"rotary error / deg", "prismatic error / in"} <= set(re.findall(r"<th>(\w+ error / \w+)</th>", text))
    assert "simulated" in text
    assert "psi" in text


@pytest.mark.slow
def test_the_page_needs_nothing_but_itself(page: Path) -> None:
    assert outside_links(page) == []
    assert "<script" not in page.read_text()
    assert page.read_text().count('<svg role="img"') == 5  # two joints, tip, spectra, oil
    assert page.stat().st_size < 3_000_000


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 400])
def test_the_page_opens_in_a_browser(page: Path, tmp_path: Path, width: int) -> None:
    seen = opened(page, tmp_path, width)
    assert seen.console == []
    assert len(seen.plots) == 5
    assert all(min(0.8 * width, 800) < shown <= width and height > 60 for shown, height in seen.plots)
    assert seen.width <= width


@pytest.mark.slow
def test_an_earlier_run_is_valid_of_the_same_maneuver_and_before(logs: list[Path], tmp_path: Path) -> None:
    assert last_valid_run(read_log(logs[1]), 2, "paper_line") == (logs[0], 1)
    assert last_valid_run(read_log(logs[0]), 1, "paper_line") is None
    assert last_valid_run(read_log(logs[1]), 2, "jog") is None


@pytest.mark.slow
def test_a_cut_log_and_one_without_a_plant_get_a_page_that_says_so(tmp_path: Path, logs: list[Path]) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(logs[1].read_bytes()[: logs[1].stat().st_size // 2])
    text = run_page(read_log(cut), 2, simulate=False)
    assert "<b>not valid</b>: the run still goes on, or the log was cut" in text
    assert "The log is still being recorded, or was cut at" in text
    with pytest.raises(UsageError, match="no such run: 9"):
        run_page(read_log(logs[1]), 9, simulate=False)


def test_a_log_without_a_run_is_refused(tmp_path: Path) -> None:
    waiting = session.Session(tmp_path / "waiting.mcap")
    waiting.cycles(session.Mode.HOLDING, 50)
    with pytest.raises(LogError, match="the log holds no run"):
        write_reports(waiting.close())


@pytest.mark.slow
def test_log_report_as_typed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    session.recorded_run(tmp_path / "a.mcap", ring_mps2={0: 2.8, 2: 2.7, 4: 3.6})
    assert main(["log", "report", str(tmp_path / "a.mcap"), "--no-simulation", "--json"]) == 0
    (made,) = json.loads(capsys.readouterr().out)["pages"]
    assert Path(made) == tmp_path / "a-run-1.html"
    assert "2.800" in Path(made).read_text()


@pytest.mark.slow
def test_every_missing_page_of_a_folder_is_made_once(tmp_path: Path) -> None:
    """Of closed recordings: a run, and a fault; not of one that is still written, nor of standby ones."""
    session.recorded_run(tmp_path / "a.mcap")
    (tmp_path / "open.mcap").write_bytes((tmp_path / "a.mcap").read_bytes()[:500_000])
    session.recorded_run(tmp_path / "a-standby.mcap")
    with simple_rig(tmp_path / "faulty") as (rig, device):
        rig.arm()
        device.override["rotary.position"] = np.nan
        rig.cycles(2100)
    rig.recorder.finished[-1].rename(tmp_path / "f.mcap")
    command = [sys.executable, "-m", "daemon.cli.main", "log", "report", "--all", str(tmp_path), "--no-simulation"]
    made = subprocess.run(command, capture_output=True, text=True, check=True)
    assert set(made.stdout.splitlines()) == {str(tmp_path / "a-run-1.html"), str(tmp_path / "f-incident-1.html")}
    assert all(Path(page).stat().st_size > 10_000 for page in made.stdout.splitlines())
    again = subprocess.run(command, capture_output=True, text=True, check=True)
    assert again.stdout == ""


@pytest.mark.slow
def test_watching_makes_the_page_of_a_log_when_it_is_closed(tmp_path: Path) -> None:
    pages = watch(tmp_path, simulate=False, say=lambda line: None)
    session.recorded_run(tmp_path / "a.mcap")
    assert next(pages) == tmp_path / "a-run-1.html"
    (tmp_path / "a.mcap").rename(tmp_path / "b.mcap")
    assert next(pages) == tmp_path / "b-run-1.html"


def test_watching_looks_once_at_a_log_that_gets_no_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever else changes in the folder meanwhile, such as the standby recording that a daemon writes all the time."""
    (tmp_path / "bad.mcap").write_bytes(MAGIC + b"no records" + MAGIC)
    looked: list[Path] = []
    turns = iter(range(3))

    def standby_goes_on(seconds: float) -> None:
        (tmp_path / "a-standby.mcap").write_bytes(b"x" * next(turns))

    def looks(log: Path) -> object:
        looked.append(log)
        return recorded(log)

    monkeypatch.setattr("daemon.reports.missing_pages.recorded", looks)
    monkeypatch.setattr("daemon.reports.missing_pages.time.sleep", standby_goes_on)
    said: list[str] = []
    with pytest.raises(RuntimeError, match="StopIteration"):
        next(watch(tmp_path, simulate=False, say=said.append))
    assert looked == [tmp_path / "bad.mcap"]
    assert len(said) == 1


def test_watching_needs_a_folder_and_a_report_a_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["log", "report"]) == 2
    assert main(["log", "report", "a.mcap", "--watch"]) == 2
    assert main(["log", "report", "--all", str(tmp_path / "nowhere")]) == 3
    assert "--all DIRECTORY" in capsys.readouterr().err
