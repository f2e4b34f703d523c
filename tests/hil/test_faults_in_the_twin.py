"""Faults in the twin where no network namespace can be made. Where one can: tests/daemon/faults/test_matrix_on_the_clock.py."""

from __future__ import annotations

import pytest

from config.errors import PlantError
from daemon.faults.benches import twin_bench
from daemon.faults.benches.twin_bench import TwinBench
from daemon.faults.fault import FaultPlace
from daemon.faults.matrix import run_matrix
from daemon.faults.twin_faults import twin_faults

pytestmark = pytest.mark.clock


def test_without_a_namespace_its_faults_are_skipped_with_the_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(name: str) -> None:
        raise PlantError("no network namespace can be made", value="not permitted")

    monkeypatch.setattr(twin_bench, "NetworkNamespace", refuse)
    with TwinBench() as bench:
        (row,) = run_matrix([next(iter(twin_faults(bench)))], dict.fromkeys(FaultPlace, 1))
    assert row.ok
    assert row.reaction == "skipped: no network namespace can be made: not permitted"
