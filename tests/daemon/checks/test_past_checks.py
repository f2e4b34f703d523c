"""`longreach why LOG --at T`: the checks of a moment that is over say what the loop said then."""

from __future__ import annotations

import datetime
import json
import re
from math import nan
from pathlib import Path

import pytest

from config.errors import UsageError
from config.loading.load import LoadedRig, apply_overrides, rig_from_text
from daemon.checks.past_checks import checks_at
from daemon.cli.main import main
from daemon.cycle.clock import LOCKSTEP_START_UNIX_NS
from daemon.lockstep import LockstepRig
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.support.daemon.rigs import JOG, RIG, simple_rig
from tests.support.daemon.simple_device import factory


@pytest.fixture(scope="module")
def faulty(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    """A recording of a run in which the rotary encoder jumps, and the time of the fault by the loop's own event."""
    with simple_rig(tmp_path_factory.mktemp("log")) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(400)
        device.override["rotary.position"] = 0.3
        rig.until(lambda: rig.mode is Mode.FAULT, 1.0)
        rig.cycles(100)
    path = rig.recorder.finished[-1]
    fault = next(event for event in read_log(path).events if event.name == "fault")
    return path, fault.t_s


def failed_at(path: Path, t_s: float | None) -> list[str]:
    return [check["name"] for check in checks_at(read_log(path), t_s).checks if check["ok"] is False]


def test_in_the_cycle_of_the_fault_the_check_that_tripped_has_failed(faulty: tuple[Path, float]) -> None:
    path, t_s = faulty
    assert failed_at(path, t_s - 0.002) == []
    assert "rotary position rate" in failed_at(path, t_s)
    log = read_log(path)
    row = next(check for check in checks_at(log, t_s).checks if check["name"] == "rotary position rate")
    position = dict(zip(log.columns["t_s"].round(6).tolist(), log.columns["rotary.position"].tolist(), strict=True))
    assert row["value"] == pytest.approx(abs(position[round(t_s, 6)] - position[round(t_s - 0.001, 6)]) / 0.001, rel=1e-6)
    text = next(event.text for event in log.events if event.name == "fault")
    assert f"{row['value']:.6g}" in text


def test_what_no_column_holds_is_said_to_be_unknown(faulty: tuple[Path, float]) -> None:
    unknown = {check["name"] for check in checks_at(read_log(faulty[0]), None).checks if check["ok"] is None}
    assert {"disk space", "recorder silent", "supervisor alive", "e-stop"} <= unknown


def test_a_lost_sensor_is_bad_quality(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.override["prismatic.position"] = nan
        rig.cycles(50)
    assert "prismatic.position quality" in failed_at(rig.recorder.finished[-1], None)


def test_a_moment_outside_is_refused_with_the_range(faulty: tuple[Path, float]) -> None:
    with pytest.raises(UsageError, match=r"the moment is outside the log: 1000 s \(limit: [\d.]+ to [\d.]+ s\)"):
        checks_at(read_log(faulty[0]), 1000.0)


def test_the_command_line(faulty: tuple[Path, float], capsys: pytest.CaptureFixture[str]) -> None:
    path, t_s = faulty
    assert main(["why", str(path), "--at", f"{t_s:.6f}"]) == 1
    shown = capsys.readouterr().out
    assert "NO  rotary position rate" in shown
    assert "ok " not in shown
    assert "?   disk space" not in shown
    assert "fault" in shown.splitlines()[-1]
    main(["why", str(path), "--at", f"{t_s:.6f}", "--all"])
    every = capsys.readouterr().out
    assert "ok  rotary travel" in every
    assert "?   disk space" in every
    assert main(["why", str(path), "--at", f"{t_s - 0.1:.6f}", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mode"] == "running"


@pytest.mark.parametrize(("last_day", "ok"), [(20, True), (-3, False)])
def test_calibrations_are_judged_by_the_time_of_the_log(tmp_path: Path, last_day: int, ok: bool) -> None:
    """Days left count from the log's own stamps to the end of the last day in UTC, whenever the log is read."""
    started = datetime.datetime.fromtimestamp(LOCKSTEP_START_UNIX_NS * 1e-9, datetime.UTC)
    until = started.date() + datetime.timedelta(days=last_day)
    key = "signals.rotary.position.calibration"
    text = apply_overrides(RIG.text, [f"{key}.valid_until={until}"])
    with LockstepRig(LoadedRig(rig_from_text(text), text, "rig.yaml"), tmp_path, create=factory([])) as rig:
        rig.arm()
        rig.cycles(1500)
    log = read_log(rig.recorder.finished[-1])
    found = next(check for check in checks_at(log, None).checks if check["name"] == "rotary.position calibration")
    end = datetime.datetime.combine(until, datetime.time(), datetime.UTC) + datetime.timedelta(days=1)
    assert found["severity"] == ("info" if ok else "warning")
    assert found["ok"] is True  # `on_expiry: warn`
    assert found["value"] == pytest.approx((end - started).total_seconds() / 86_400, abs=1e-4)


def test_the_command_line_shows_the_units_of_the_logs_rig_file(faulty: tuple[Path, float], capsys: pytest.CaptureFixture[str]) -> None:
    path, t_s = faulty
    main(["why", str(path), "--at", f"{t_s:.6f}", "--all"])
    shown = capsys.readouterr().out
    main(["why", str(path), "--at", f"{t_s:.6f}", "--all", "--si"])
    si = capsys.readouterr().out
    for name, unit, stated in (("rotary.supply_pressure limit", "Pa", "psi"), ("rotary travel", "rad", "deg")):
        (line,), (si_line,) = ([row for row in text.splitlines() if row[4:].startswith(name)] for text in (shown, si))
        assert f" {stated} " in line
        assert f" {unit} " in si_line
    for text, numbers in ((shown, r"\d+ deg/s \(limit ≤ 240 deg/s\)"), (si, r"[\d.]+ rad/s \(limit ≤ 4\.18879 rad/s\)")):
        (fault,) = (row for row in text.splitlines() if row.split()[2:3] == ["fault"])
        assert re.search(numbers, fault), "the fault's own sentence"
