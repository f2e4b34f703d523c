"""The whole way on a simulated axis: from a folder of recordings to a page. Machines change as their rig file says, and only so."""

from __future__ import annotations

import json
import re
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from config.errors import LogError
from config.loading.load import rig_from_text
from daemon.cli.main import main
from gap.watch import kept_fits
from gap.watch.watch import watch
from tests.support.gap import axis_logs, worn_axis

FRICTION = "axis.coulomb_friction.friction"
TEXT = axis_logs.axis_text()


def with_friction(newtons: float) -> str:
    return TEXT.replace("friction: 20.39 N", f"friction: {newtons:.6g} N")


def quiet(line: str) -> None:
    return


@pytest.fixture(scope="module")
def week(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six recordings of 3 s: the friction rises from the rig file's to 30 N before the fourth; two logs that cannot be used."""
    folder = tmp_path_factory.mktemp("week")
    (folder / "logs").mkdir()
    (folder / "axis.yaml").write_text(TEXT)
    for k, moment in enumerate(worn_axis.moments(6)):
        machine = rig_from_text(with_friction(20.39 if k < 3 else 30.0))
        path = folder / "logs" / f"run {9 - k}.mcap"
        worn_axis.write_recording(path, axis_logs.simulated(machine, 40 + k, 3.0), moment, machine.name)
    (folder / "logs" / "20260401-short.csv").write_text("t_s,axis.position,axis.command_V\n0,0,0\n")
    (folder / "logs" / "copy.mcap").write_bytes((folder / "logs" / "run 9.mcap").read_bytes())
    return folder


@pytest.mark.slow
def test_a_step_is_found_at_its_log_and_the_page_stands_alone(week: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["gap", "watch", "--rig", str(week / "axis.yaml"), "--logs", str(week / "logs"), "--out", str(week / "out"), "--workers", "1"]
    assert main([*words, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content == json.loads((week / "out" / "watch.json").read_text())
    friction = content["numbers"][FRICTION]
    assert (friction["course"], [step["log"] for step in friction["steps"]]) == ("steps", ["run 6.mcap"])
    assert friction["steps"][0]["by"] == pytest.approx(30.0 - 20.39, abs=0.2)
    assert friction["now"]["ci95"][0] < 30.0 < friction["now"]["ci95"][1]
    assert content["alarms"] == [FRICTION], "3 standard deviations of 10 % are exceeded"
    assert [(Path(one["log"]).name, one["why"]) for one in content["unusable"]] == [
        ("20260401-short.csv", "no part of the log is long enough: 1 rows of 1 (limit: 100 rows without a gap of 1 s)"),
        ("run 9.mcap", "it is the same as copy.mcap"),
    ]
    page = (week / "out" / "watch.html").read_text()
    assert page.count("data:image/png;base64,") == sum(one["now"] is not None for one in content["numbers"].values())
    assert "http" not in re.sub(r"base64,[^\"']*", "", page)


def test_what_was_fitted_is_kept_and_an_alarm_is_no_error(
    week: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    rig, logs, out = week / "axis.yaml", week / "logs", week / "out"
    watch(rig, logs, out, quiet, workers=1)

    def never(*_: object) -> None:
        raise AssertionError("a log was fitted again")

    monkeypatch.setattr(kept_fits, "fit_log", never)
    words = ["gap", "watch", "--rig", str(rig), "--logs", str(logs), "--out", str(out)]
    assert main(words) == 0
    assert capsys.readouterr().out.startswith(f"alarm: {FRICTION}; 6 logs from 2026-03-02 to 2026-03-12.\n")
    assert main([*words, "--limit", f"{FRICTION}=35 N", "--since", "2026-03-04"]) == 0
    assert capsys.readouterr().out.startswith("no alarm; 5 logs from 2026-03-04")
    rig.write_text(TEXT.replace("mass: 95.1089 kg ", "mass: 95.1080 kg "))
    try:
        with pytest.raises(AssertionError, match="fitted again"):
            watch(rig, logs, out, quiet, workers=1)
    finally:
        rig.write_text(TEXT)


def test_a_folder_of_which_no_log_can_be_used_is_unusable_data(tmp_path: Path) -> None:
    (tmp_path / "20260401-short.csv").write_text("t_s,axis.position,axis.command_V\n0,0,0\n")
    with pytest.raises(LogError, match="none of the 1 logs can be used; the first: no part of the log is long enough") as refused:
        watch("force_axis", tmp_path, tmp_path / "out", quiet, workers=1)
    assert "@FROM:TO" not in str(refused.value), "no part of a log can be given to it"
    words = ["gap", "watch", "--rig", "force_axis", "--logs", str(tmp_path), "--out", str(tmp_path / "out"), "--workers", "1"]
    assert main(words) == 3


def test_where_since_leaves_no_log_it_is_named_and_not_a_log_without_a_date(tmp_path: Path) -> None:
    for name in ("20260401-a.csv", "undated.csv"):
        (tmp_path / name).write_text("t_s,axis.position,axis.command_V\n0,0,0\n")
    with pytest.raises(LogError, match="1 of 2 logs began before --since") as refused:
        watch("force_axis", tmp_path, tmp_path / "out", quiet, since=datetime(2026, 5, 1, tzinfo=UTC))
    assert refused.value.refusal.mend == {"--since": None}


@pytest.mark.slow
def test_a_healthy_axis_raises_no_alarm_in_24_logs(tmp_path: Path) -> None:
    """Noise and maneuvers differ, the machine does not: another mass and another damping than its file says, in every log alike."""
    truth = TEXT.replace("mass: 95.1089 kg", "mass: 96.5 kg").replace("coefficient: 203.5", "coefficient: 210")
    worn_axis.write_tables(tmp_path / "logs", worn_axis.moments(24), lambda k: truth, seed=100)
    (tmp_path / "axis.yaml").write_text(TEXT)
    found = watch(tmp_path / "axis.yaml", tmp_path / "logs", tmp_path / "out", quiet, workers=1)
    assert found.alarms == []
    assert [one.word for one in found.numbers] == ["steady"] * 3


@pytest.mark.slow
def test_drifts_and_repairs_are_within_their_intervals(tmp_path: Path) -> None:
    """Three axes of 12 logs: damping grows by 1.5 N s/m a day, friction falls at a repair. Of the truths 95 % lie in their intervals."""
    held, steps = [], []
    (tmp_path / "axis.yaml").write_text(TEXT)
    for seed in range(3):
        draw = np.random.default_rng(seed)
        high, repair = draw.uniform(26.0, 40.0), int(draw.integers(4, 9))

        def truth(k: int, high: float = high, repair: int = repair) -> str:
            friction = high if k < repair else 20.39
            return with_friction(friction).replace("coefficient: 203.5", f"coefficient: {203.5 + 3.0 * k:.6g}")

        worn_axis.write_tables(tmp_path / f"{seed}", worn_axis.moments(12), truth, seed=1000 * (seed + 1))
        found = watch(tmp_path / "axis.yaml", tmp_path / f"{seed}", tmp_path / f"out{seed}", quiet, workers=1)
        by_name = {one.number.name: one for one in found.numbers}
        friction, damping = by_name[FRICTION], by_name["axis.viscous_friction.coefficient"]
        assert friction.course is not None
        assert damping.course is not None
        assert (damping.word, damping.alarm) == ("drifts", False)
        steps.append(friction.course.steps == (repair,))
        height, width = friction.course.step(0)
        slope, half = damping.course.slope
        held += [abs(height - (20.39 - high)) < width, abs(slope - 1.5) < half]
        held += [abs(one.now[0] - now) < one.now[1] for one, now in ((friction, 20.39), (damping, 236.5))]
    assert all(steps)
    assert sum(held) >= 10, "of 12; fewer than 10 have a chance of 2 %"
