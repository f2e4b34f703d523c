"""The benchmark of the commands measures what it says: processor time of the command alone, and safe outputs that are safe."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from benchmarks.commands import Row, commands, estops, quantile, timed
from daemon.faults.benches.daemon_process import DaemonProcess


def test_a_command_is_timed_as_a_process_of_its_own() -> None:
    own = time.process_time()
    wall, processor = timed(["status", "--help"])
    assert 0.005 < processor <= wall + 0.02  # the kernel counts in ticks
    assert time.process_time() - own < processor


def test_every_command_gets_as_many_runs() -> None:
    rows = list(commands(2, [("status", "--help"), ("--socket", "/nowhere", "estop")]))
    assert [row.what for row in rows] == ["longreach status --help", "longreach estop"]
    assert all(len(row.wall_s) == len(row.processor_s) == 2 for row in rows)


@pytest.mark.parametrize(("share", "value"), [(0.5, 6.0), (0.9, 10.0), (1.0, 10.0)])
def test_quantiles(share: float, value: float) -> None:
    assert quantile([float(number) for number in range(10, 0, -1)], share) == value


def test_a_row_names_its_median_and_worst() -> None:
    assert Row("estop", [0.1, 0.3, 0.2]).text().split() == ["estop", "0.200", "0.300", "0.300"]


def test_estop_is_timed_to_outputs_that_are_safe_and_can_be_repeated(tmp_path: Path) -> None:
    with DaemonProcess(tmp_path) as daemon:
        row = estops(daemon, 2, "estop")
        register = daemon.register()
        assert register.effective(time.monotonic_ns()) == register.safe_values
        assert daemon.connect().call("status")["mode"] == "disarmed"  # reset after the last one
    assert len(row.wall_s) == 2
    assert all(0.0 < wall < 10.0 for wall in row.wall_s)
