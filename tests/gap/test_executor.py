"""The same answers from processes and from a Dask cluster of two workers; refusals that say what to do."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from config.errors import ConfigError
from config.loading.load import rig_from_text
from gap.executor import each, executor
from gap.study import line, run_search, run_study, searches
from tests.support.gap.axis_logs import axis_text, simulated, write


def cube(number: int) -> int:
    return number**3


def process_of(_: int) -> int:
    return os.getpid()


def fails(number: int) -> int:
    raise ValueError(f"task {number}")


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    distributed = pytest.importorskip("distributed", reason="the extra longreach[dask] is not installed")
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with distributed.LocalCluster(**options) as local:
        yield local.scheduler_address


def test_processes_answer_each_task_once() -> None:
    with executor(2) as pool:
        assert dict(each(pool, cube, range(7))) == {k: k**3 for k in range(7)}


@pytest.mark.slow
def test_tasks_run_in_other_processes_and_a_failing_one_is_raised_here() -> None:
    with executor(1) as pool:
        assert {pid for _, pid in each(pool, process_of, [0, 1])}.isdisjoint({os.getpid()})
        with pytest.raises(ValueError, match="task 3"):
            list(each(pool, fails, [3]))


@pytest.mark.slow
def test_no_scheduler_is_a_clear_refusal() -> None:
    pytest.importorskip("distributed", reason="the extra longreach[dask] is not installed")
    with pytest.raises(ConfigError, match="no Dask scheduler answers"), executor(dask="tcp://127.0.0.1:9"):
        pass


def test_two_pairs_of_one_name_are_refused(tmp_path: Path) -> None:
    pair = (tmp_path / "a" / "log.csv", tmp_path / "b.csv")
    with pytest.raises(ConfigError, match="two pairs"):
        searches("force_axis", [pair, (tmp_path / "c" / "log.csv", tmp_path / "b.csv")], tmp_path)


def test_unusable_logs_are_a_row_and_no_crash(tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("t_s,axis.position\n0,0\n")
    todo = searches("force_axis", [(tmp_path / "x.csv", tmp_path / "x.csv")], tmp_path / "out")
    row = run_search(todo[0])
    assert row["verdict"] == "refused"
    assert line(row).startswith("x: refused:")


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_dask_and_processes_find_the_same(tmp_path: Path, cluster: str) -> None:
    model = tmp_path / "model.yaml"
    model.write_text(axis_text("coulomb_friction"))
    whole = rig_from_text(axis_text())
    logs = [write(tmp_path / f"log{seed}.csv", simulated(whole, seed, 8.0)) for seed in (1, 2, 3)]
    pairs = [(logs[0], logs[1]), (logs[1], logs[2])]
    answers = []
    for name, where in (("processes", {"workers": 2}), ("dask", {"dask": cluster})):
        told: list[str] = []
        out = tmp_path / name
        rows = run_study(searches(str(model), pairs, out), out, told.append, **where)  # type: ignore[arg-type]
        assert len(told) == 2
        assert json.loads((out / "study.json").read_text()) == json.loads(json.dumps(rows))
        answers.append([comparable(row) for row in rows])
    assert answers[0] == answers[1]
    assert all(row["findings"][0]["effect"] == "coulomb_friction" for row in answers[0])


def comparable(row: dict[str, Any]) -> dict[str, Any]:
    return json.loads(json.dumps(row))
