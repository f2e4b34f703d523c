"""`longreach host` says which rates are kept, and its exit status whether the rig's is."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from config.errors import EXIT_REFUSED, ConfigError
from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from daemon.cli.main import main
from daemon.cli.operate import measured_rate
from daemon.host.kept_grade import KeptGrade, grade_path, kept
from daemon.host.rate_seen import RateSeen


@pytest.fixture(autouse=True)
def kept_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))


KEPT = RateSeen(
    rate_Hz=1000.0,
    held=True,
    cycles=4000,
    late_p50_s=2e-6,
    late_p99_s=30e-6,
    late_p999_s=90e-6,
    work_p99_s=150e-6,
    largest_s=0.001,
    overruns=3,
    in_window=2,
    lost=0,
    refused=(),
    window_s=1.0,
    stop_after=20,
    fault_late_s=0.05,
)


def kept_up_to(limit_Hz: float, refused: tuple[str, ...] = ()) -> object:
    def measure(loaded: LoadedRig, rate_Hz: float, seconds: float) -> RateSeen:
        return replace(KEPT, rate_Hz=rate_Hz, in_window=2 if rate_Hz <= limit_Hz else 21, refused=refused)

    return measure


@pytest.mark.parametrize(("limit_Hz", "status"), [(2000.0, 0), (1000.0, 0), (500.0, EXIT_REFUSED), (0.0, EXIT_REFUSED)])
def test_the_grade_is_the_highest_rate_up_to_which_all_are_kept(
    limit_Hz: float, status: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(measured_rate, "measure", kept_up_to(limit_Hz))
    assert main(["host", "--json", "--seconds", "0.5"]) == status
    answer = json.loads(capsys.readouterr().out)
    assert answer["grade_Hz"] == limit_Hz
    assert [rate["rate_Hz"] for rate in answer["rates"]] == [250, 500, 1000, 2000]
    assert all(cause["value"] for cause in answer["causes"])


def test_for_people_it_says_what_was_refused_and_what_comes_next(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(measured_rate, "measure", kept_up_to(500.0, ("real-time priority: SCHED_FIFO 80 refused",)))
    main(["host", "--seconds", "0.5"])
    said = capsys.readouterr().out
    assert "SCHED_FIFO 80 refused" in said
    assert "this computer keeps 500 Hz; ornl_testbed asks for 1000 Hz. Next: do what stands above" in said


def test_a_rate_that_the_rigs_bus_cannot_carry_is_no_failure_of_the_computer() -> None:
    with pytest.raises(ConfigError, match=r"at 2000 Hz = \d+\.\d % of 1 Mbit/s"):
        measured_rate.measure(load_rig("ornl_testbed_can"), 2000.0)


def test_why_there_are_no_higher_rates_is_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def measure(loaded: LoadedRig, rate_Hz: float, seconds: float) -> RateSeen:
        if rate_Hz > 1000.0:
            raise ConfigError("the bus is too slow")
        return replace(KEPT, rate_Hz=rate_Hz, held=False)

    monkeypatch.setattr(measured_rate, "measure", measure)
    assert main(["host", "--seconds", "0.5"]) == 0
    said = capsys.readouterr().out
    assert "no higher rate: 2000 Hz: the bus is too slow" in said
    assert "devices read, outputs safe" in said
    assert "keeps 1000 Hz" in said


def test_what_it_found_is_kept_for_the_daemon_of_that_rig(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measured_rate, "measure", kept_up_to(1000.0))
    main(["host", "--json", "--seconds", "0.5", "--load"])
    grade = kept(grade_path())
    assert grade is not None
    assert (grade.grade_Hz, grade.loaded) == (1000.0, True)
    assert KeptGrade(load_rig("ornl_testbed").rig).rate_Hz == 1000.0
    assert KeptGrade(rig_from_text(apply_overrides(load_rig("ornl_testbed").text, ["loop.cpu=1"]))).rate_Hz == 0.0


def test_a_place_that_cannot_be_written_is_told_and_changes_no_status(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path / "file"))
    monkeypatch.setattr(measured_rate, "measure", kept_up_to(1000.0))
    assert main(["host", "--json", "--seconds", "0.5"]) == 0
    said = capsys.readouterr().err
    assert "not kept for the daemon: " in said
    assert "the host grade cannot be written" in said


@pytest.mark.slow
@pytest.mark.clock
def test_it_measures_the_daemon_on_this_computer_beside_a_load(capsys: pytest.CaptureFixture[str]) -> None:
    main(["host", "--json", "--seconds", "0.5", "--load"])
    rates = json.loads(capsys.readouterr().out)["rates"]
    assert [rate["rate_Hz"] for rate in rates] == [250, 500, 1000, 2000]
    assert any(rate["held"] for rate in rates)  # beside a load arming may be refused: a sample comes late
    assert all(rate["cycles"] > 0.2 * 0.5 * rate["rate_Hz"] for rate in rates)  # periods that were missed count for none
    assert all(0 <= rate["late_p50_s"] <= rate["late_p99_s"] <= rate["late_p999_s"] for rate in rates)


def test_devices_that_do_not_answer_are_told_with_the_rig_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["host", "--rig", "ornl_testbed_can", "--seconds", "0.5"]) == EXIT_REFUSED
    said = capsys.readouterr().err
    assert "ornl_testbed_can.yaml" in said
    assert "the daemon ended while starting" in said
