"""`gap find` at the command line: what it asks of the search, and that nobody waits for a proposal to read the verdict."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from config.errors import LogError
from config.loading.load import LoadedRig
from daemon.cli.main import main
from gap import conclusion, find
from gap.data.log_parts import load_parts
from gap.settings import Settings
from tests.support.gap import axis_logs


@pytest.mark.parametrize(
    ("flags", "propose", "si"), [([], True, False), (["--no-next"], False, False), (["--no-next", "--si"], False, True)]
)
def test_flags_reach_the_search(flags: list[str], propose: bool, si: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Settings] = []

    def instead(rig: object, logs: object, holdouts: object, out: object, progress: object, settings: Settings, unused: object) -> None:
        asked.append(settings)
        raise LogError("asked")

    monkeypatch.setattr(find, "find", instead)
    assert main(["gap", "find", "--rig", "force_axis", "--log", "a.csv", "--holdout", "b.csv", *flags]) == 3
    assert [(one.propose, one.si) for one in asked] == [(propose, si)]


@pytest.mark.slow
def test_the_verdict_is_told_before_a_maneuver_is_looked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []
    before: list[list[str]] = []

    def instead(*_: Any) -> None:
        before.append(list(told))

    monkeypatch.setattr(conclusion, "next_of", instead)
    text = axis_logs.axis_text("coulomb_friction")
    loaded = LoadedRig(axis_logs.axis_rig("coulomb_friction"), text, "axis.yaml")
    logs = [load_parts([axis_logs.write(tmp_path / f"{k}.csv", axis_logs.simulated(axis_logs.axis_rig(), k, 6.0))], loaded.rig)[0]
            for k in (11, 12)]  # fmt: skip
    find.search_gap(loaded, logs[:1], logs[1:], told.append, Settings(workers=1))
    assert len(before) == 1
    assert any(line.startswith("verdict: named: coulomb_friction at axis (friction 20.") for line in before[0])
