"""What `longreach host` found is kept, counts for the same computer and the same wishes alone, and lets a rig arm that demands it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from config.errors import DaemonError
from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from daemon.faults.benches.daemon_process import PATIENCE, DaemonProcess, wait_for
from daemon.host import kept_grade
from daemon.host.kept_grade import HostGrade, KeptGrade, grade_path, keep, measured_for
from daemon.lockstep import LockstepRig
from recording.files.reader import read_log
from servo_control.signals import Mode

TEXT = load_rig("ornl_testbed").text
RIG = rig_from_text(TEXT)
SEEN = HostGrade(1000.0, "2026-11-23 12:00", True, ("locked memory",), measured_for(RIG))
DEMAND = "loop.demand_rate=true"


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "state"
    monkeypatch.setenv("STATE_DIRECTORY", str(folder))
    return folder


def test_a_measurement_counts_from_the_moment_it_is_kept() -> None:
    grade = KeptGrade(RIG)
    assert (grade.rate_Hz, grade.row()["value"]) == (0.0, "nothing measured")
    keep(SEEN)
    grade.look()
    assert grade.rate_Hz == 1000.0
    assert grade.row()["value"] == "1000 Hz, seen 2026-11-23 12:00 UTC beside a load"
    grade_path().unlink()
    grade.look()
    assert grade.rate_Hz == 0.0


def other_rig(*overrides: str) -> dict[str, object]:
    return measured_for(rig_from_text(apply_overrides(TEXT, overrides)))


@pytest.mark.parametrize(
    ("other", "named"),
    [
        (replace(SEEN, holds_for={**SEEN.holds_for, "host_kernel": "Linux 5.10 old"}), "host_kernel was Linux 5.10 old"),
        (replace(SEEN, holds_for=other_rig("loop.cpu=1")), "loop.cpu was 1"),
        (replace(SEEN, holds_for=other_rig("loop.priority=10")), "loop.priority was 10"),
        (replace(SEEN, holds_for=measured_for(load_rig("ornl_testbed_can").rig)), "the rig's devices were others"),
        (replace(SEEN, holds_for={}), "host_name was None"),
        (replace(SEEN, loaded=False), "it was measured without a load"),
    ],
)
def test_another_computer_or_another_wish_does_not_count_and_is_named(other: HostGrade, named: str) -> None:
    keep(other)
    grade = KeptGrade(RIG)
    assert grade.rate_Hz == 0.0
    assert f"which does not count: {named}" in grade.said


def test_a_right_that_was_granted_then_and_is_refused_now_does_not_count() -> None:
    """The other way round, the daemon has more than the measurement had."""
    keep(SEEN)
    grade = KeptGrade(RIG)
    grade.look(["locked memory"])
    assert grade.rate_Hz == 1000.0
    grade.look(["locked memory", "real-time priority"])
    assert grade.rate_Hz == 0.0
    assert grade.said.endswith("which does not count: real-time priority was granted")
    grade.look([])
    assert grade.rate_Hz == 1000.0


def test_gains_and_limits_are_no_part_of_it() -> None:
    assert other_rig("joints.rotary.rate_limit=20 deg/s") == SEEN.holds_for


@pytest.mark.parametrize("content", ["", "{", "[1]", '{"grade_Hz": 1000}'])
def test_a_file_that_cannot_be_read_is_no_measurement(content: str, state: Path) -> None:
    state.mkdir()
    grade_path().write_text(content)
    assert KeptGrade(RIG).rate_Hz == 0.0


def test_the_place_is_the_services_where_there_is_one_and_else_the_users(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("STATE_DIRECTORY")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "own"))
    monkeypatch.setattr(kept_grade, "SERVICE_STATE_DIRECTORY", tmp_path / "service")
    assert grade_path() == tmp_path / "own" / "longreach" / "host_grade.json"
    (tmp_path / "service").mkdir()
    assert grade_path() == tmp_path / "service" / "host_grade.json"


def test_the_virtual_clock_keeps_any_rate(tmp_path: Path) -> None:
    with LockstepRig(demanding(), tmp_path) as rig:
        rig.arm()
        assert rig.mode is Mode.HOLDING


def test_only_a_rig_that_demands_it_has_the_check(tmp_path: Path) -> None:
    with LockstepRig(load_rig("ornl_testbed"), tmp_path) as rig:
        assert all(check.name != "host keeps the rate" for check in rig.loop.keeper.checks)


@pytest.mark.slow
def test_a_daemon_refuses_to_arm_until_the_rate_was_seen_and_then_arms(tmp_path: Path, state: Path) -> None:
    holds_for = other_rig(*PATIENCE)
    with DaemonProcess(tmp_path, [DEMAND]) as daemon, daemon.connect() as client:
        assert client.call("events")["events"][0]["text"] == "host grade: nothing measured"
        client.call("reset")
        with pytest.raises(DaemonError, match=r"host keeps the rate .*: 0 Hz \(limit ≥ 1000 Hz\).*longreach host"):
            client.call("arm")
        keep(replace(SEEN, grade_Hz=500.0, holds_for=holds_for))
        wait_for(lambda: row(client.call("checks"), "host keeps the rate")["value"] == 500.0)
        with pytest.raises(DaemonError, match="host keeps the rate"):
            client.call("arm")
        keep(replace(SEEN, holds_for=holds_for))
        wait_for(lambda: row(client.call("checks"), "host keeps the rate")["ok"])
        assert row(client.call("checks"), "rates seen before")["value"].startswith("1000 Hz, seen 2026-11-23")
        client.call("arm")
        wait_for(lambda: client.call("status")["mode"] == "holding")
        grade_path().unlink()
        wait_for(lambda: row(client.call("checks"), "host keeps the rate")["value"] == 0.0)
        status = client.call("status")
        assert status["mode"] == "holding"
        assert read_log(Path(status["log"]["path"])).metadata["recording"]["host_grade"] == "nothing measured"


def demanding() -> LoadedRig:
    text = apply_overrides(load_rig("ornl_testbed").text, [DEMAND])
    return LoadedRig(rig_from_text(text), text, "demanding.yaml")


def row(answer: dict[str, list[dict[str, object]]], name: str) -> dict[str, object]:
    return next(each for each in answer["checks"] if each["name"] == name)
