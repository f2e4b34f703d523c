"""What led to a fault, for faults put into a lockstep rig: the first cause, the order, the commands, the checks, and the page."""

from __future__ import annotations

import json
import shutil
from math import nan
from pathlib import Path

import numpy as np
import pytest

from config.errors import LogError, UsageError
from daemon.checks.check_history import check_history
from daemon.cli.main import main
from daemon.modes.mode_machine import OperatorAction
from daemon.reports.incident import Incident, incident_of
from daemon.reports.incident_page import write_incidents
from recording.evaluation.replay import reexecute
from recording.files.catalogue import logs_in
from recording.files.reader import Log, read_log
from servo_control.signals import Mode
from tests.support.daemon.rigs import JOG, simple_rig
from tests.support.recording import session
from tests.support.static_page import opened, outside_links

LOW_PA = 9e6


@pytest.fixture(scope="module")
def faulty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Low pressure begins a controlled stop; 40 ms later the encoder is lost, which is the fault."""
    with simple_rig(tmp_path_factory.mktemp("faulty")) as (rig, device):
        rig.arm()
        rig.start({"maneuver": {"name": "paper_line"}, "shaper": {"kind": "zvd"}, "approach": True})
        rig.cycles(1000)
        device.override["rotary.supply_pressure"] = LOW_PA
        rig.cycles(40)
        device.override["rotary.position"] = nan
        rig.cycles(2100)
    return rig.recorder.finished[-1]


@pytest.fixture(scope="module")
def log(faulty: Path) -> Log:
    return read_log(faulty)


@pytest.fixture(scope="module")
def incident(log: Log) -> Incident:
    return incident_of(log)


def test_the_first_cause_is_the_oldest_failure_that_held(incident: Incident, log: Log) -> None:
    assert incident.first is not None
    assert incident.first.check.name == "rotary.supply_pressure limit"
    low = int(np.argmax(log.columns["rotary.supply_pressure_Pa"] == LOW_PA))
    assert incident.first.row == low
    assert incident.t_s - incident.cause_t_s == pytest.approx(0.040, abs=1e-6)
    assert "rotary.position quality" in incident.fault.text


def test_consequences_come_in_their_order(incident: Incident) -> None:
    names = [step.what for step in incident.steps if step.t_s >= incident.cause_t_s]
    wanted = ["rotary.supply_pressure limit fails", "mode", "rotary.position quality fails", "fault", "run_ended"]
    assert [names.index(name) for name in wanted] == sorted(names.index(name) for name in wanted)
    assert [step.t_s for step in incident.steps] == sorted(step.t_s for step in incident.steps)


def test_the_commands_before_it_and_the_checks_then(incident: Incident) -> None:
    assert [step.what for step in incident.commands] == ["countdown", "run_started"]
    assert '"kind": "zvd"' in incident.commands[-1].text
    failed = {check["name"] for check in incident.moment.checks if check["ok"] is False}
    assert {"rotary.supply_pressure limit", "rotary.position quality"} <= failed


def test_the_history_ends_as_the_moment_says(log: Log, incident: Incident) -> None:
    """Asked cycle by cycle or at once, the same checks fail."""
    history = check_history(log, 0, incident.row)
    acting = {change.check.name for change in history.failing.values()}
    failed = {check["name"] for check in incident.moment.checks if check["ok"] is False}
    assert acting == failed
    np.testing.assert_array_equal(
        history.numbers["rotary.supply_pressure limit"], log.columns["rotary.supply_pressure_Pa"][: incident.row + 1]
    )


def test_what_failed_long_before_an_e_stop_is_not_its_cause(tmp_path: Path) -> None:
    """A holding arm whose pump is off goes on holding; that somebody then stops it is not the pump's doing."""
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.override["rotary.supply_pressure"] = 9e6
        rig.cycles(1500)
        assert rig.mode is Mode.HOLDING
        rig.post(OperatorAction.ESTOP)
        rig.cycles(2100)
    found = incident_of(read_log(rig.recorder.finished[-1]))
    assert found.first is None
    assert found.cause == "e-stop was asked for"


def test_an_e_stop_has_no_failed_check_and_is_a_command(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, _):
        rig.arm()
        rig.start(JOG)
        rig.cycles(300)
        rig.post(OperatorAction.ESTOP)
        rig.cycles(2100)
    found = incident_of(read_log(rig.recorder.finished[-1]))
    assert found.first is None
    assert found.cause == "e-stop was asked for"
    assert found.commands[-1].text == "e-stop was asked for"


@pytest.mark.slow
def test_the_page_says_it_all_and_needs_nothing_but_itself(faulty: Path) -> None:
    ((page, own_log),) = write_incidents(faulty)
    assert page == faulty.with_name(f"{faulty.stem}-incident-1.html")
    assert f"{own_log.name}, beside this page" in page.read_text()
    text = page.read_text()
    assert "First cause, 40 ms before the fault" in text
    assert "docs/reference/checks.md#signal-quality" in text
    for heading in ("What to look at", "From the first cause on", "Commands before it", "The last 30 s", "Checks at that moment"):
        assert f"<h2>{heading}" in text, heading
    assert outside_links(page) == []
    row = f"<td>NO</td><td>rotary.supply_pressure limit</td><td>{LOW_PA / 6894.757:.1f}</td><td>psi</td>"
    assert row in text  # as the rig file states it


@pytest.mark.slow
def test_the_page_opens_in_a_browser(faulty: Path, tmp_path: Path) -> None:
    ((page, _),) = write_incidents(faulty)
    for width in (1280, 400):
        seen = opened(page, tmp_path, width)
        assert seen.console == []
        assert len(seen.plots) == 3
        assert all(min(0.8 * width, 800) < shown <= width and height > 60 for shown, height in seen.plots)
        assert seen.width <= width


@pytest.mark.slow
def test_why_leads_to_the_page(faulty: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = faulty.with_name(f"{faulty.stem}-incident-1.html")
    page.unlink(missing_ok=True)
    main(["why", str(faulty), "--json"])
    assert json.loads(capsys.readouterr().out)["incident"] == f"longreach log incident {faulty} --fault 1"
    assert main(["log", "incident", str(faulty), "--json"]) == 0
    made = json.loads(capsys.readouterr().out)
    assert (made["pages"], made["logs"]) == ([str(page)], [str(page.with_suffix(".mcap"))])
    assert main(["log", "incident", str(faulty)]) == 0
    assert str(page.with_suffix(".mcap")) in capsys.readouterr().out
    main(["why", str(faulty), "--at", "0.5"])
    assert f"what led to the fault: {page}" in capsys.readouterr().out


@pytest.mark.slow
def test_the_time_before_the_fault_is_a_log_of_its_own(
    faulty: Path, log: Log, incident: Incident, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Alone in another folder it says the same: first cause, checks, and it executes again; its folder lists it as no recording."""
    monkeypatch.setattr("daemon.reports.incident_page.BEFORE_S", 0.5)
    ((page, own_log),) = write_incidents(faulty)
    alone = Path(shutil.copy(own_log, tmp_path))
    cut = incident_of(read_log(alone))
    assert cut.reaches_back_s == pytest.approx(0.5, abs=2e-3)
    assert (cut.cause, cut.cause_t_s, cut.fault) == (incident.cause, incident.cause_t_s, incident.fault)
    asked, then = ([(check["name"], check["ok"]) for check in checks] for checks in (cut.moment.checks, incident.moment.checks))
    assert asked == then
    assert reexecute(alone).identical
    assert f"longreach replay {own_log.name}" in page.read_text()
    assert logs_in([faulty.parent]) == [faulty]


def test_a_log_without_a_fault_is_refused_and_a_fault_that_there_is_not(tmp_path: Path, faulty: Path) -> None:
    session.recorded_run(tmp_path / "a.mcap")
    with pytest.raises(LogError, match="holds no fault"):
        write_incidents(tmp_path / "a.mcap")
    with pytest.raises(UsageError, match=r"holds no such fault: 9 \(limit: 1 to 1\)"):
        write_incidents(faulty, 9)


def test_the_recording_that_a_log_continues_is_looked_at_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A long arming is cut between two runs; the run before the cut is a command before the fault."""
    monkeypatch.setattr("daemon.loop.recording_span.ARMED_S", 2.0)
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.until(lambda: len(rig.recorder.finished) == 1)
        rig.cycles(300)
        device.override["rotary.position"] = nan
        rig.cycles(2100)
    first, second = map(read_log, rig.recorder.finished)
    found = incident_of(second)
    assert found.reaches_back_s == pytest.approx(found.t_s - first.columns["t_s"][0], abs=2e-3)
    assert found.log.columns["cycle"].tolist() == [*first.columns["cycle"].tolist(), *second.columns["cycle"].tolist()]
    assert found.log.columns["cycle"][found.row] == found.fault.cycle
    assert [step.what for step in found.commands] == ["countdown", "run_started"]
    assert found.first is not None
    assert found.first.row == found.row
    assert incident_of(read_log(second.path)).first == found.first
    second.path.rename(tmp_path / "alone.mcap")
    first.path.unlink()
    assert incident_of(read_log(tmp_path / "alone.mcap")).commands == ()
