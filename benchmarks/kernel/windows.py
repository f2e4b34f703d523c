"""How much processor time a search's simulations take: a log of the simulated testbed in windows of 0.4 s, carried and restarted.

Run: python -m benchmarks.kernel.windows
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from config.loading.load import load_rig
from sim_backend.kernel.batch import WindowPlan, carry, quiet, restart
from sim_backend.memory.layout import TARGETS, D, Target, Vector
from sim_backend.plant import SimulatedRig

PERIOD_S, LOG_S = 1e-3, 24.0
BURN_IN, ROWS, EVERY = 300, 400, 3  # periods: before the first window, in a window, from one reading to the next
MOVED_RAD_PER_S = 1e-3
REPEATS = 9


def main() -> None:
    """Print processor milliseconds a simulated second: the least of several repeats, which disturbances only lengthen."""
    sim = SimulatedRig(load_rig("ornl_testbed").rig)
    sim.parameters.values[:] = quiet(sim.parameters)
    sim.reset()
    p, start = sim.parameters.values, sim.state.copy()
    plan = _plan(sim)
    _, kept = carry(start, p, plan, keep=True)
    windows_s = len(plan.starts) * ROWS * PERIOD_S
    _report("carry", windows_s + BURN_IN * PERIOD_S, lambda: carry(start, p, plan))
    _report("restart", windows_s, lambda: restart(kept, p, plan, int(D.VELOCITY), MOVED_RAD_PER_S))


def _plan(sim: SimulatedRig) -> WindowPlan:
    """Adjoining windows of a log whose measured motion is the simulation's own."""
    t = np.arange(round(LOG_S / PERIOD_S)) * PERIOD_S
    commands: Vector = np.column_stack([0.5 * np.sin(2 * np.pi * t), 2 * np.sin(2 * np.pi * 0.7 * t)])
    motion = sim.run(commands, PERIOD_S)
    targets = np.full((t.size, TARGETS), np.nan)
    for slot, joint in enumerate(("rotary", "prismatic")):
        targets[:, Target.POSITION + slot], targets[:, Target.VELOCITY + slot] = motion[f"{joint}.position"], motion[f"{joint}.velocity"]
    starts = np.arange(BURN_IN, t.size - ROWS, ROWS)
    return WindowPlan(commands, starts, ROWS, EVERY, PERIOD_S, targets)


def _report(name: str, simulated_s: float, work: Callable[[], object]) -> None:
    print(f"{name:31} {min(_processor_s(work) for _ in range(REPEATS)) / simulated_s * 1e3:8.2f} ms of processor time a simulated second")


def _processor_s(work: Callable[[], object]) -> float:
    before = time.process_time()
    work()
    return time.process_time() - before


if __name__ == "__main__":
    main()
