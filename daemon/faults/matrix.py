"""The fault matrix: every fault with all its trials, one after the other, each trial in a directory of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

from config.errors import LongreachError
from daemon.faults.fault import NEVER_MS, Fault, Row, Trial
from daemon.faults.loop_faults import loop_faults
from daemon.faults.process_faults import process_faults
from daemon.faults.sensor_faults import sensor_faults

QUICK_TRIALS = 2
PROCESS_TRIALS = 5  # each starts a daemon, which takes seconds


def all_faults(processes: bool = True) -> tuple[Fault, ...]:
    """Every fault this computer can inject; without `processes` only those that the loop sees in lockstep."""
    return (*sensor_faults(), *loop_faults(), *(process_faults() if processes else ()))


def run_matrix(faults: Iterable[Fault], trials: int, process_trials: int, tell: Callable[[Row], None] | None = None) -> Iterator[Row]:
    """Rows as they are measured; `tell` hears of each. A trial that could not be made counts as one that never became safe."""
    for fault in faults:
        row = Row(fault)
        for number in range(process_trials if fault.process else trials):
            row.trials.append(_trial(fault, number))
        if tell:
            tell(row)
        yield row


def _trial(fault: Fault, number: int) -> Trial:
    with TemporaryDirectory(prefix="longreach-faults-") as directory:
        try:
            return fault.run(Random(number), Path(directory))
        except LongreachError as error:
            return Trial(NEVER_MS, f"not measured: {error}")
