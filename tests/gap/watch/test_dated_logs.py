"""When a log was recorded: its stamps, else its name; what cannot be told is listed with a command."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest

from config.errors import LogError
from gap.watch.dated_logs import dated_logs
from tests.support.gap import axis_logs, worn_axis

RIG = axis_logs.axis_rig()


def recording(path: Path, rig_name: str = RIG.name, begun: datetime = worn_axis.BEGUN) -> Path:
    return worn_axis.write_recording(path, axis_logs.simulated(RIG, 1, 0.2), begun, rig_name)


def test_stamps_go_before_names_and_order_the_logs(tmp_path: Path) -> None:
    later, first = worn_axis.moments(2)
    recording(tmp_path / "rig-20200101-000000.mcap", begun=first)
    recording(tmp_path / "b.mcap", begun=later)
    (tmp_path / "notes.md").write_text("no log")
    logs, refused = dated_logs(tmp_path, RIG.name)
    assert [(log.path.name, log.begun) for log in logs] == [("b.mcap", later), ("rig-20200101-000000.mcap", first)]
    assert refused == []


@pytest.mark.parametrize(
    ("name", "moment"),
    [
        ("axis-20260302-143015.csv", (2026, 3, 2, 14, 30, 15)),
        ("2026-03-02_steps.csv", (2026, 3, 2)),
        ("steps 2026-03-02T14-30.csv", (2026, 3, 2, 14, 30)),
    ],
)
def test_tables_have_their_date_in_the_name(name: str, moment: tuple[int, ...], tmp_path: Path) -> None:
    (tmp_path / name).write_text("t_s\n")
    (log,), _ = dated_logs(tmp_path, RIG.name)
    assert log.begun == datetime(*moment, tzinfo=UTC)  # type: ignore[misc,arg-type]


@pytest.mark.parametrize("name", ["steps.csv", "run-20261340.csv", "12345678901234.csv"])
def test_a_name_without_a_date_is_told_with_the_command_to_type(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("t_s\n")
    logs, (refused,) = dated_logs(tmp_path, RIG.name)
    assert logs == []
    assert refused.why == "nothing says when it was recorded"
    assert refused.next_step.endswith(f"mv {tmp_path / name} {tmp_path / f'YYYY-MM-DDTHHMM-{name}'}")


def test_cut_recordings_and_those_of_other_rigs_are_told(tmp_path: Path) -> None:
    whole = recording(tmp_path / "whole.mcap", rig_name="other")
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[:-100])
    logs, refused = dated_logs(tmp_path, RIG.name)
    assert logs == []
    assert [(one.path.name, one.why) for one in refused] == [
        ("cut.mcap", "it is still being recorded, or was cut"),
        ("whole.mcap", f"it is of another rig: other (limit: {RIG.name})"),
    ]
    assert refused[0].next_step == f"longreach log recover {cut}"


def test_nothing_is_recovered_from_an_empty_file(tmp_path: Path) -> None:
    (tmp_path / "empty.mcap").write_bytes(b"")
    _, (refused,) = dated_logs(tmp_path, RIG.name)
    assert (refused.why, "log recover" in refused.next_step) == ("the file is empty", False)


def test_a_folder_without_logs_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="holds no logs"):
        dated_logs(tmp_path, RIG.name)
    with pytest.raises(LogError, match="no such folder"):
        dated_logs(tmp_path / "none", RIG.name)
