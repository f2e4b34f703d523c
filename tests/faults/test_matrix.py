"""The fault matrix itself: enough faults, every one ends as it must within its limit, and the command says so in every form."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import pytest

from config.load import load_rig
from daemon.cli.main import main
from daemon.faults import kept
from daemon.faults.fault import INFERRED_MS, NEVER_MS, SEEN_MS, Fault, Row, Trial, Until, Where
from daemon.faults.lockstep_bench import Scene, lockstep_trial
from daemon.faults.matrix import all_faults, run_matrix
from daemon.faults.process_bench import ProcessBench
from daemon.faults.report import page
from daemon.faults.twin_bench import TwinBench

FAULTS = all_faults(ProcessBench(), TwinBench())
LOCKSTEP = [fault for fault in FAULTS if fault.where is Where.LOOP]


def row_of(fault: Fault, trials: int) -> Row:
    return next(iter(run_matrix([fault], dict.fromkeys(Where, trials))))


def test_at_least_thirty_faults_that_the_loop_sees_and_every_name_once() -> None:
    names = [fault.name for fault in FAULTS]
    assert len(LOCKSTEP) >= 30
    assert len(set(names)) == len(names)


def test_what_the_loop_sees_is_safe_within_20_ms_unless_a_device_is_silent_or_slow() -> None:
    slower = {fault.name: fault.limit_ms for fault in LOCKSTEP if fault.until is Until.SAFE and fault.limit_ms > SEEN_MS}
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

    def nothing(scene: Scene) -> None:
        assert scene.rig.mode.name == "RUNNING"

    trial = lockstep_trial(nothing, Until.SAFE, "rotary")(Random(1), tmp_path)
    assert trial.time_ms == NEVER_MS
    assert trial.reaction == "none: the run goes on"


def test_a_row_is_ok_only_when_all_trials_react_as_expected_in_time() -> None:
    fault = Fault("x", "g", "fault: x", Until.SAFE, 20.0, lambda chance, directory: Trial(1.0, ""))
    good, slow, other = Trial(2.0, "fault: x"), Trial(21.0, "fault: x"), Trial(2.0, "fault: y")
    assert Row(fault, [good, good]).ok
    assert not Row(fault, [good, slow]).ok
    assert not Row(fault, [good, other]).ok
    assert Row(fault, [good, other]).reaction == "fault: y"
    late = Fault("x", "g", "stop", Until.REST, 5000.0, fault.run, began_limit_ms=20.0)
    assert Row(late, [Trial(80.0, "stop", 3.0)]).ok
    assert not Row(late, [Trial(80.0, "stop", 30.0)]).ok
    assert not Row(late, [Trial(80.0, "stop")]).ok
    never = Row(fault, [good, Trial(NEVER_MS, "fault: x")])
    assert not never.ok
    assert never.as_dict()["time_to_safe_ms"]["worst"] is None
    text = page([Row(fault, [good]), Row(fault, [slow])], "longreach faults")
    assert "1 of 2 do not end as they must: x." in text
    assert "| x | loop | fault: x | outputs safe | 2.0 | 2.0 | 20 | 1 | ok |" in text


def test_on_a_busy_machine_the_median_and_most_of_the_reactions_judge() -> None:
    fault = Fault("x", "g", "fault: x", Until.SAFE, 20.0, lambda chance, directory: Trial(1.0, ""))
    good, slow, other = Trial(2.0, "fault: x"), Trial(NEVER_MS, "fault: x"), Trial(2.0, "fault: y")
    assert Row(fault, [good, good, slow], by_median=True).ok
    assert Row(fault, [good, good, other], by_median=True).ok
    assert not Row(fault, [good, slow, other], by_median=True).ok
    assert not Row(fault, [good, slow], by_median=True).ok


def test_on_a_busy_machine_what_is_not_ok_is_measured_again() -> None:
    times = iter((NEVER_MS, 3.0, 4.0))
    fault = Fault("x", "g", "", Until.SAFE, 20.0, lambda chance, directory: Trial(next(times), ""))
    (row,) = run_matrix([fault], dict.fromkeys(Where, 1), by_median=True)
    assert row.ok
    assert (row.median_ms, row.worst_ms, len(row.trials)) == (4.0, NEVER_MS, 3)


def test_what_cannot_be_injected_here_is_skipped_and_says_why() -> None:
    fault = Fault("x", "g", "", Until.SAFE, 20.0, lambda chance, directory: Trial(NEVER_MS, ""), Where.TWIN, "no network namespace")
    row = row_of(fault, 3)
    assert row.ok
    assert row.as_dict()["skipped"]
    assert row.trials == []
    assert "skipped: no network namespace" in page([row], "longreach faults")
    assert "1 could not be injected here" in page([row], "longreach faults")


def test_trials_kept_in_a_file_are_not_made_again(tmp_path: Path) -> None:
    made: list[int] = []

    def run(chance: Random, directory: Path) -> Trial:
        made.append(1)
        return Trial(NEVER_MS if len(made) == 1 else 3.0, "fault: x", 1.5)

    fault, file = Fault("x", "g", "fault: x", Until.SAFE, 20.0, run), tmp_path / "kept.json"
    numbers = dict.fromkeys(Where, 2)
    kept.add(file, row_of(fault, 1))
    (row,) = run_matrix([fault], numbers, before=kept.read(file))
    kept.add(file, row)
    assert row.trials == kept.read(file)["x"] == [Trial(NEVER_MS, "fault: x", 1.5), Trial(3.0, "fault: x", 1.5)]
    assert len(made) == 2


def test_the_command_prints_json_writes_a_page_and_fails_when_nothing_is_chosen(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "faults.md"
    assert main(["faults", "--quick", "--where", "loop", "--only", "rotary encoder jump", "--json", "--page", str(target)]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert {"fault", "reaction", "time_to_safe_ms", "limit_ms", "ok"} <= set(row)
    assert row["time_to_safe_ms"]["median"] <= row["time_to_safe_ms"]["worst"] <= row["limit_ms"] == 20.0
    assert "--only 'rotary encoder jump'" in target.read_text()
    assert main(["faults", "--where", "loop", "--only", "no such fault"]) == 1
