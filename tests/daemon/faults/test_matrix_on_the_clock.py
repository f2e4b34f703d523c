"""What the fault matrix measures on the wall clock, a trial a row: whole processes, and devices behind CAN and Modbus."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import pytest

from daemon.faults.benches.process_bench import ProcessBench
from daemon.faults.benches.twin_bench import TwinBench
from daemon.faults.fault import Fault, FaultPlace
from daemon.faults.matrix import all_faults, run_matrix

pytestmark = [pytest.mark.clock, pytest.mark.slow]

ON_THE_CLOCK = [fault.name for fault in all_faults(ProcessBench(), TwinBench()) if fault.where is not FaultPlace.LOOP]


@pytest.fixture(scope="module")
def faults() -> Iterator[Mapping[str, Fault]]:
    """By name. The daemons go on from row to row; what one row breaks is started anew."""
    with ProcessBench() as processes, TwinBench(processes.end) as twin:
        yield {fault.name: fault for fault in all_faults(processes, twin)}


@pytest.mark.parametrize("name", ON_THE_CLOCK)
def test_every_fault_ends_as_it_must(name: str, faults: Mapping[str, Fault]) -> None:
    (row,) = run_matrix([faults[name]], dict.fromkeys(FaultPlace, 1), by_median=True)
    if row.skipped:
        pytest.skip(row.reaction)
    assert row.ok, row.as_dict()
