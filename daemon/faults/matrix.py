"""The fault matrix: every fault with all its trials, one after the other, each trial in a directory of its own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

from config.errors import LongreachError
from daemon.faults.benches.process_bench import ProcessBench
from daemon.faults.benches.twin_bench import TwinBench
from daemon.faults.fault import NEVER_MS, Fault, FaultPlace, FaultRow, FaultTrial
from daemon.faults.hand_faults import hand_faults
from daemon.faults.loop_faults import loop_faults
from daemon.faults.process_faults import process_faults
from daemon.faults.sensor_faults import sensor_faults
from daemon.faults.twin_faults import twin_faults

QUICK_TRIALS = 2
RETRIES = 2
SLOW_TRIALS = 5  # on the wall clock, seconds each


def all_faults(processes: ProcessBench, twin: TwinBench) -> tuple[Fault, ...]:
    """Every fault there is; the benches make the trials that need more than the loop."""
    return (*sensor_faults(), *loop_faults(), *process_faults(processes), *hand_faults(processes), *twin_faults(twin))


def run_matrix(
    faults: Iterable[Fault],
    trials: Mapping[FaultPlace, int],
    by_median: bool = False,
    before: Mapping[str, Sequence[FaultTrial]] | None = None,
) -> Iterator[FaultRow]:
    """Rows as they are measured. A trial that could not be made counts as one that never became safe. `before`: trials made earlier,
    by the fault's name; only what is missing is made. `by_median`: a row that is not as it must be gets RETRIES more trials, and most of
    them decide; a machine with other users may stand still in one of them.
    """
    for fault in faults:
        row = FaultRow(fault, by_median=by_median)
        if not fault.impossible:
            row.trials += (before or {}).get(fault.name, ())
            _more(row, trials[fault.where])
            if by_median and not row.ok:
                _more(row, len(row.trials) + RETRIES)
        yield row


def _more(row: FaultRow, wanted: int) -> None:
    row.trials += [_trial(row.fault, number) for number in range(len(row.trials), wanted)]


def _trial(fault: Fault, number: int) -> FaultTrial:
    with TemporaryDirectory(prefix="longreach-faults-") as directory:
        try:
            return fault.run(Random(number), Path(directory))
        except LongreachError as error:
            return FaultTrial(NEVER_MS, f"not measured: {error}")
