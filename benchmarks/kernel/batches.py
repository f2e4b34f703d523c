"""Batches of parameter vectors, as the gap search simulates them, on one and on two threads: how much faster, and whether the bits agree.

    python -m benchmarks.kernel.batches [--pairs 12] [--vectors 16]

As `gap.fitting.simulate` does it: one compiled call a vector, threads taking the next vector. One and two threads take turns. Wall time
says what an idle machine gains; on a busy one only the processor time compares: two threads that stood in each other's way would need more
of it.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from statistics import median

import numpy as np
from numpy.typing import NDArray

from config.loading.load import load_rig
from gap.data.windows import Experiment
from gap.fitting.model import Model
from gap.fitting.simulate import simulate
from sim_backend.kernel.batch import carry
from sim_backend.memory.layout import C, Vector
from tests.support.gap import testbed_logs

Array = NDArray[np.float64]
LOG_S = 24.0
WANTED = 1.8


def on_threads(experiment: Experiment, vectors: Sequence[Vector], threads: int) -> list[Array]:
    return simulate(replace(experiment, workers=threads), vectors)


def made(count: int) -> tuple[Experiment, list[Vector]]:
    """A log of the simulated testbed in windows, and vectors that differ in the payload."""
    rig = load_rig("ornl_testbed").rig
    t = 1e-3 * np.arange(round(LOG_S / 1e-3))
    commands = np.column_stack([0.5 * np.sin(2 * np.pi * t), 0.6 * np.sin(2 * np.pi * 0.7 * t)])
    experiment = replace(testbed_logs.experiment(rig, commands, 3, rig), warmer_K=0.0)
    vector = Model(rig, (), np.empty(0)).vector()
    vectors = [vector.copy() for _ in range(count)]
    for number, each in enumerate(vectors):
        each[C.PAYLOAD] *= 1.0 + 0.01 * number
    return experiment, vectors


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Wall and processor seconds of all threads."""
    wall, processor = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - wall, time.process_time() - processor


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--pairs", type=int, default=12, metavar="N", help="turns of one and two threads (default %(default)s)")
    parser.add_argument("--vectors", type=int, default=16, metavar="N", help="in a batch (default %(default)s)")
    arguments = parser.parse_args()
    experiment, vectors = made(arguments.vectors)
    single = [carry(experiment.start, p, experiment.plan)[0][:, :, list(experiment.columns)] for p in vectors]
    print(
        f"{arguments.vectors} vectors, {experiment.windows} windows; medians (range) of {arguments.pairs} pairs; wall time wanted: {WANTED}"
    )
    same = all(np.array_equal(a, b) for n in (1, 2) for a, b in zip(single, on_threads(experiment, vectors, n), strict=True))
    print(f"readings {'bit-identical to' if same else 'DIFFER from'} those of single calls")
    one, two = (partial(on_threads, experiment, vectors, threads) for threads in (1, 2))
    pairs = [(timed(one), timed(two)) for _ in range(arguments.pairs)]
    wall = sorted(alone[0] / both[0] for alone, both in pairs)
    spent = sorted(both[1] / alone[1] for alone, both in pairs)
    each_ms = 1e3 * median(alone[1] for alone, _ in pairs) / arguments.vectors
    print(f"wall, 1 over 2 threads {median(wall):.2f} ({wall[0]:.2f} to {wall[-1]:.2f}); "
          f"processor, 2 over 1 {median(spent):.3f} ({spent[0]:.3f} to {spent[-1]:.3f}); {each_ms:.1f} ms a vector")  # fmt: skip


if __name__ == "__main__":
    main()
