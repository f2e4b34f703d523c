"""The fault matrix itself: enough faults, every one ends as it must within its limit, and the command says so in every form."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import pytest

from config.loading.load import load_rig
from daemon.cli.main import main
from daemon.faults import trial_file
from daemon.faults.benches.lockstep_bench import LockstepTarget, lockstep_trial
from daemon.faults.benches.process_bench import ProcessBench
from daemon.faults.benches.twin_bench import TwinBench
from daemon.faults.fault import INFERRED_MS, NEVER_MS, SEEN_MS, Expected, Fault, FaultPlace, FaultRow, FaultTrial, Until
from daemon.faults.matrix import all_faults, run_matrix
from daemon.faults.report import page

FAULTS = all_faults(ProcessBench(), TwinBench())
LOCKSTEP = [fault for fault in FAULTS if fault.where is FaultPlace.LOOP]


def row_of(fault: Fault, trials: int) -> FaultRow:
    return next(iter(run_matrix([fault], dict.fromkeys(FaultPlace, trials))))


def test_at_least_thirty_faults_that_the_loop_sees_and_every_name_once() -> None:
    names = [fault.name for fault in FAULTS]
    assert len(LOCKSTEP) >= 30
    assert len(set(names)) == len(names)


def test_what_the_loop_sees_is_safe_within_20_ms_unless_a_device_is_silent_or_slow() -> None:
    slower = {
        fault.name: fault.expected.limit_ms
        for fault in LOCKSTEP
        if fault.expected.until is Until.SAFE and fault.expected.limit_ms > SEEN_MS
    }
    timeout_ms = load_rig("ornl_testbed").rig.devices["plant"].timeout_s * 1e3
    inferred = {name for name, limit in slower.items() if limit == INFERRED_MS}
    assert inferred == {"rotary valve cable off", "prismatic valve cable off"}
    assert (
        max(limit for name, limit in slower.items() if name not in {*inferred, "thermometer late", "loop stalled 100 ms"})
        <= timeout_ms + 10.0
    )


@pytest.mark.parametrize("fault", LOCKSTEP, ids=lambda fault: fault.name)
def test_every_fault_that_the_loop_sees_ends_as_it_must(fault: Fault) -> None:
    row = row_of(fault, 1)
    assert row.ok, row.as_dict()


def test_a_trial_without_a_fault_is_not_safe(tmp_path: Path) -> None:
    """The instrument does not call everything safe, and the loop does not call everything a fault."""

    def nothing(target: LockstepTarget) -> None:
        assert target.rig.mode.name == "RUNNING"

    trial = lockstep_trial(nothing, Until.SAFE, "rotary")(Random(1), tmp_path)
    assert trial.time_ms == NEVER_MS
    assert trial.reaction == "none: the run goes on"


def test_a_row_is_ok_only_when_all_trials_react_as_expected_in_time() -> None:
    fault = Fault("x", "g", Expected("fault: x", Until.SAFE, 20.0), lambda rng, directory: FaultTrial(1.0, ""))
    good, slow, other = FaultTrial(2.0, "fault: x"), FaultTrial(21.0, "fault: x"), FaultTrial(2.0, "fault: y")
    assert FaultRow(fault, [good, good]).ok
    assert not FaultRow(fault, [good, slow]).ok
    assert not FaultRow(fault, [good, other]).ok
    assert FaultRow(fault, [good, other]).reaction == "fault: y"
    late = Fault("x", "g", Expected("stop", Until.REST, 5000.0), fault.run, began_limit_ms=20.0)
    assert FaultRow(late, [FaultTrial(80.0, "stop", 3.0)]).ok
    assert not FaultRow(late, [FaultTrial(80.0, "stop", 30.0)]).ok
    assert not FaultRow(late, [FaultTrial(80.0, "stop")]).ok
    never = FaultRow(fault, [good, FaultTrial(NEVER_MS, "fault: x")])
    assert not never.ok
    assert never.as_dict()["time_to_safe_ms"]["worst"] is None
    text = page([FaultRow(fault, [good]), FaultRow(fault, [slow])], "longreach faults")
    assert "1 of 2 do not end as they must: x." in text
    assert "| x | loop | fault: x | outputs safe | 2.0 | 2.0 | 20 | 1 | ok |" in text


def test_on_a_busy_machine_the_median_and_most_of_the_reactions_judge() -> None:
    fault = Fault("x", "g", Expected("fault: x", Until.SAFE, 20.0), lambda rng, directory: FaultTrial(1.0, ""))
    good, slow, other = FaultTrial(2.0, "fault: x"), FaultTrial(NEVER_MS, "fault: x"), FaultTrial(2.0, "fault: y")
    assert FaultRow(fault, [good, good, slow], by_median=True).ok
    assert FaultRow(fault, [good, good, other], by_median=True).ok
    assert not FaultRow(fault, [good, slow, other], by_median=True).ok
    assert not FaultRow(fault, [good, slow], by_median=True).ok


def test_on_a_busy_machine_what_is_not_ok_is_measured_again() -> None:
    times = iter((NEVER_MS, 3.0, 4.0))
    fault = Fault("x", "g", Expected("", Until.SAFE, 20.0), lambda rng, directory: FaultTrial(next(times), ""))
    (row,) = run_matrix([fault], dict.fromkeys(FaultPlace, 1), by_median=True)
    assert row.ok
    assert (row.median_ms, row.worst_ms, len(row.trials)) == (4.0, NEVER_MS, 3)


def test_what_cannot_be_injected_here_is_skipped_and_says_why() -> None:
    fault = Fault(
        "x", "g", Expected("", Until.SAFE, 20.0), lambda rng, directory: FaultTrial(NEVER_MS, ""), FaultPlace.TWIN, "no network namespace"
    )
    row = row_of(fault, 3)
    assert row.ok
    assert row.as_dict()["skipped"]
    assert row.trials == []
    assert "skipped: no network namespace" in page([row], "longreach faults")
    assert "1 could not be injected here" in page([row], "longreach faults")


def test_trials_kept_in_a_file_are_not_made_again(tmp_path: Path) -> None:
    made: list[int] = []

    def run(rng: Random, directory: Path) -> FaultTrial:
        made.append(1)
        return FaultTrial(NEVER_MS if len(made) == 1 else 3.0, "fault: x", 1.5)

    fault, file = Fault("x", "g", Expected("fault: x", Until.SAFE, 20.0), run), tmp_path / "trials.json"
    numbers = dict.fromkeys(FaultPlace, 2)
    trial_file.add(file, row_of(fault, 1))
    (row,) = run_matrix([fault], numbers, before=trial_file.read(file))
    trial_file.add(file, row)
    assert row.trials == trial_file.read(file)["x"] == [FaultTrial(NEVER_MS, "fault: x", 1.5), FaultTrial(3.0, "fault: x", 1.5)]
    assert len(made) == 2


def test_the_command_prints_json_writes_a_page_and_fails_when_nothing_is_chosen(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "faults.md"
    assert main(["faults", "--quick", "--where", "loop", "--only", "rotary encoder jump", "--json", "--page", str(target)]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert {"fault", "reaction", "time_to_safe_ms", "limit_ms", "ok"} <= set(row)
    assert row["time_to_safe_ms"]["median"] <= row["time_to_safe_ms"]["worst"] <= row["limit_ms"] == 20.0
    assert "--only 'rotary encoder jump'" in target.read_text()
    assert main(["faults", "--where", "loop", "--only", "no such fault"]) == 2
