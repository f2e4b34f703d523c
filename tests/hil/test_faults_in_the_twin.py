"""Trials of the fault matrix in the twin: one that leaves the daemon whole, one that kills it, and the reason where there can be none."""

from __future__ import annotations

import pytest

from config.errors import PlantError
from daemon.faults.benches import twin_bench
from daemon.faults.benches.twin_bench import TwinBench
from daemon.faults.fault import Fault, FaultPlace, FaultRow
from daemon.faults.matrix import run_matrix
from daemon.faults.twin_faults import twin_faults

pytestmark = pytest.mark.clock


def fault_of(bench: TwinBench, name: str) -> Fault:
    return next(fault for fault in twin_faults(bench) if fault.name == f"CAN: {name}")


def row_of(fault: Fault) -> FaultRow:
    return next(run_matrix([fault], dict.fromkeys(FaultPlace, 1), by_median=True))


@pytest.mark.slow
def test_trials_over_can_and_modbus() -> None:
    with TwinBench() as bench:
        if bench.impossible:
            pytest.skip(bench.impossible)
        for name in (
            "rotary encoder off",
            "Modbus black hole",
            "host dies (all processes SIGKILLed)",
            "rotary valve leaves ACTIVE by itself",
        ):
            row = row_of(fault_of(bench, name))
            assert row.ok, row.as_dict()


def test_without_a_namespace_its_faults_are_skipped_with_the_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(name: str) -> None:
        raise PlantError("no network namespace can be made", value="not permitted")

    monkeypatch.setattr(twin_bench, "NetworkNamespace", refuse)
    with TwinBench() as bench:
        row = row_of(fault_of(bench, "bus off"))
    assert row.ok
    assert row.reaction == "skipped: no network namespace can be made: not permitted"
