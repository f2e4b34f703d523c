"""The soak's count of allocated blocks: a process answers a signal with it, and growth is told from what comes and goes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from benchmarks.loop.soak import COUNTED
from benchmarks.loop.soak_report import blocks_line

_CHILD = """
import os, signal
os.kill(os.getpid(), signal.SIGUSR1)
kept = [object() for _ in range(5000)]
os.kill(os.getpid(), signal.SIGUSR1)
del kept
os.kill(os.getpid(), signal.SIGUSR1)
"""


def _counts(path: Path, *words: str) -> list[int]:
    """Of a child with these words after its program."""
    environment = {**os.environ, "PYTHONPATH": f"{COUNTED}{os.pathsep}{COUNTED.parents[2]}", "LONGREACH_COUNTS": str(path)}
    subprocess.run([sys.executable, "-c", _CHILD, *words], env=environment, check=bool(words))  # without them the signal ends the child
    return [int(line.split()[0]) for line in path.read_text().splitlines()] if path.exists() else []


def test_the_control_process_counts_its_blocks_when_it_is_asked_to(tmp_path: Path) -> None:
    before, held, after = _counts(tmp_path / "a.txt", "daemon.processes.control_process")
    assert held - before >= 5000
    assert abs(after - before) < 500


def test_the_other_processes_do_not(tmp_path: Path) -> None:
    assert _counts(tmp_path / "a.txt") == []


def test_growth_is_that_of_quarters_and_not_of_single_counts() -> None:
    assert blocks_line([5000, 100, 101, 100, 100, 102, 9000, 100, 100, 100, 100, 100]).endswith("grew by -1")
    assert blocks_line([100 + 10 * number for number in range(8)]).endswith("of the first quarter 105, of the last 165: grew by +60")
    assert "too few" in blocks_line([1, 2, 3])
