"""How fast the simulated testbed runs: many periods in one compiled call, and one period a call from Python; processor time.

Run: python -m benchmarks.kernel
"""

from __future__ import annotations

import statistics
import time

import numpy as np

from config.loading.load import load_rig
from sim_backend.plant import SimulatedRig

PERIOD_S = 1e-3
BULK_PERIODS = 20_000
SINGLE_CALLS = 5_000
REPEATS = 7


def main() -> None:
    """Print the ratio to real time and the cost of single calls; medians and best of several repeats."""
    started = time.process_time()
    sim = SimulatedRig(load_rig("ornl_testbed").rig)
    print(f"load, build and settle          {time.process_time() - started:8.2f} s")
    t = np.arange(BULK_PERIODS) * PERIOD_S
    commands = np.column_stack([0.5 * np.sin(2 * np.pi * t), 2 * np.sin(2 * np.pi * 0.7 * t)])
    for name, sense in (("bulk, true signals", False), ("bulk, with sensed counts", True)):
        seconds = [_timed(lambda sense=sense: _bulk(sim, commands, sense)) for _ in range(REPEATS)]
        ratios = [BULK_PERIODS * PERIOD_S / value for value in seconds]
        print(f"{name:31} {statistics.median(ratios):8.0f} x real time (best {max(ratios):.0f})")
    for name, call in (("advance(1 ms) from Python", lambda: sim.advance((0.1, 0.2), PERIOD_S)), ("sense() from Python", sim.sense)):
        costs = [_timed(lambda call=call: _repeated(call)) / SINGLE_CALLS * 1e6 for _ in range(REPEATS)]
        print(f"{name:31} {statistics.median(costs):8.2f} us (best {min(costs):.2f})")


def _bulk(sim: SimulatedRig, commands: np.ndarray, sense: bool) -> None:
    sim.reset()
    sim.run(commands, PERIOD_S, sense=sense)


def _repeated(call: object) -> None:
    for _ in range(SINGLE_CALLS):
        call()  # type: ignore[operator]


def _timed(work: object) -> float:
    started = time.process_time()
    work()  # type: ignore[operator]
    return time.process_time() - started


if __name__ == "__main__":
    main()
