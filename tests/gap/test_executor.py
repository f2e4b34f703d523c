"""The same answers from processes and from a Dask cluster of two workers; refusals that say what to do."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from socketserver import BaseRequestHandler, ThreadingTCPServer
from threading import Thread
from typing import Any

import pytest

from config.errors import ConfigError
from config.loading.load import rig_from_text
from daemon.cli.main import main
from gap.executor import each, executor
from gap.study import line, run_search, run_study, searches
from tests.support.daemon.processes import is_alive
from tests.support.daemon.running_daemon import until
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
def test_what_a_process_does_ends_when_the_context_is_left() -> None:
    with executor(1) as pool:
        (worker,) = {pid for _, pid in each(pool, process_of, [0])}
        pool.submit(time.sleep, 600.0)
    until(lambda: not is_alive(worker), 20.0)


@pytest.mark.slow
def test_what_a_process_does_ends_when_whoever_asked_is_killed() -> None:
    asking = subprocess.Popen([sys.executable, "-c", ASKS], stdout=subprocess.PIPE, text=True)
    assert asking.stdout is not None
    worker = int(asking.stdout.readline())
    asking.kill()
    asking.wait()
    until(lambda: not is_alive(worker), 20.0)


ASKS = """
import os, time
from gap.executor import executor
if __name__ == "__main__":
    with executor(1) as pool:
        print(pool.submit(os.getpid).result(), flush=True)
        pool.submit(time.sleep, 600.0).result()
"""


@pytest.fixture
def stranger() -> Iterator[str]:
    """The address of a server that answers whatever it is asked with bytes of its own."""
    with ThreadingTCPServer(("127.0.0.1", 0), Babble) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"tcp://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


class Babble(BaseRequestHandler):
    def handle(self) -> None:
        self.request.sendall(b"HTTP/1.1 400 Bad Request\r\n" * 40)


@pytest.mark.parametrize(
    ("address", "text"),
    [
        ("tcp://127.0.0.1:9", "no Dask scheduler answers within 0.3 s: tcp://127.0.0.1:9"),
        ("stranger", "no Dask scheduler answers within 0.3 s: tcp://127.0.0.1:"),
        ("localhost", "no address of a Dask scheduler: 'localhost'"),
        ("http://localhost:8786", "no address of a Dask scheduler: 'http://localhost:8786'"),
        ("", "no address of a Dask scheduler: ''"),
    ],
)
def test_what_is_no_scheduler_is_refused_in_a_sentence(
    address: str, text: str, stranger: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """As the command line says it; a Client would leave the tracebacks of its threads behind."""
    pytest.importorskip("distributed", reason="the extra longreach[dask] is not installed")
    monkeypatch.setattr("gap.executor.CONNECT_S", 0.3)
    words = ["simulate", "ornl_testbed", "hold", "--sweep", "servo.rotary.gain=4..5:2", "-o", str(tmp_path / "s.mcap")]
    assert main([*words, "--dask", stranger if address == "stranger" else address]) == 1
    refused, following = capfd.readouterr().err.splitlines()
    assert refused.startswith(f"longreach: --dask: {text}")
    assert "Write tcp://HOST:PORT" in refused
    assert following.startswith("next: longreach simulate")
    assert not list(tmp_path.glob("s*"))


@pytest.fixture
def idle(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """A cluster of this process whose scheduler has no worker."""
    distributed = pytest.importorskip("distributed", reason="the extra longreach[dask] is not installed")
    monkeypatch.setattr("gap.executor.SOON_S", 0.05)
    with distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=None) as local:
        yield local


def test_a_scheduler_without_a_worker_is_told_and_given_up(idle: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gap.executor.WORKER_S", 0.2)
    told: list[str] = []
    refusal = r"no worker joined the Dask scheduler within 0\.2 s.*Start one: dask worker "
    with pytest.raises(ConfigError, match=refusal), executor(dask=idle.scheduler_address, progress=told.append):
        pass
    assert told == [
        f"the Dask scheduler {idle.scheduler_address} has no worker; waiting 0.2 s for one. Start one: dask worker {idle.scheduler_address}"
    ]


def test_a_worker_that_joins_after_all_does_the_work(idle: Any) -> None:
    told: list[str] = []

    def starts_one(line: str) -> None:
        told.append(line)
        idle.scale(1)

    with executor(dask=idle.scheduler_address, progress=starts_one) as pool:
        assert dict(each(pool, cube, range(3))) == {k: k**3 for k in range(3)}
    assert len(told) == 1


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
@pytest.mark.long
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
