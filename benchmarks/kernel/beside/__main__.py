"""The kernel beside C and scipy's stiff solvers, with the accuracy of each beside its speed.

Run: python -m benchmarks.kernel.beside [--solved 2]

Commands are those of the paper's line, run in lockstep once; every way gets the same. Speeds are processor time; ways take turns, and
ratios are medians over the turns. C draws the sensors' noise as the kernel does; the solvers have no sensors, so the kernel beside them has
none. Errors are the largest difference from Radau at rtol 1e-10 (over the solved part) and from the kernel with 1/100 ms steps
(over the whole program), in % of each signal's swing. Less than a second of the program mostly times the call from Python, 17 us, which
is as long as 30 periods.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import longreach
from benchmarks.kernel.beside.c_version import COLUMNS, CPlant
from benchmarks.kernel.beside.solvers import Solved
from config.loading.load import load_rig
from sim_backend.memory.layout import C
from sim_backend.plant import SimulatedRig

Array = NDArray[np.float64]
Signals = dict[str, Array]
PERIOD_S = 1e-3
FINE_S = 1e-5
TURNS = 15
_IN_C = "C, -O3 -march=native"
_BARE = "kernel without sensors"  # what the solvers are compared with: they have none
SOLVER_TURNS, KERNEL_RUNS = 5, 20  # of a solver, and of the kernel beside each: its own run is too short to be timed
SOLVERS = (("LSODA", 1e-4), ("LSODA", 3e-5), ("LSODA", 1e-6), ("BDF", 1e-5))  # relative tolerances


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--solved", type=float, default=2.0, help="seconds of the program that the solvers run (default %(default)s)")
    solved_s = parser.parse_args().solved
    commands = _paper_line()
    sim = SimulatedRig(load_rig("ornl_testbed").rig)
    whole = len(commands) * PERIOD_S
    fine = _from_start(sim, commands, FINE_S)
    kernel = _from_start(sim, commands, None)
    print(f"the paper's line, {whole:.1f} s; errors in % of a signal's swing; processor time", flush=True)
    _line("kernel, steps of 0.01 ms", None, 0.0)
    ways = _ways(sim, commands)
    seconds = _in_turns(ways)
    for name, way in ways.items():
        _line(name, whole / statistics.median(seconds[name]), _worst(way(), fine))
    if _IN_C in seconds:
        ratios = sorted(a / b for a, b in zip(seconds["kernel"], seconds[_IN_C], strict=True))
        print(f"time of the kernel over that of C: {statistics.median(ratios):.2f} ({ratios[1]:.2f} to {ratios[-2]:.2f} of {TURNS} turns)")
    _solvers(sim, commands, kernel, solved_s)


def _ways(sim: SimulatedRig, commands: Array) -> dict[str, Callable[[], Signals]]:
    """What is timed by name; without C where there is no compiler, which is said."""
    ways: dict[str, Callable[[], Signals]] = {"kernel": lambda: _from_start(sim, commands, None)}
    try:
        plant = CPlant(sim, PERIOD_S)
    except FileNotFoundError as missing:
        print(missing)
    else:
        ways[_IN_C] = lambda: _c_run(plant, sim, commands)
    return ways


def _solvers(sim: SimulatedRig, commands: Array, kernel: Signals, solved_s: float) -> None:
    start = int(np.argmax(np.abs(commands).max(axis=1) > 0.05))  # where the first move begins
    rows = slice(start, start + round(solved_s / PERIOD_S))
    sim.reset()
    sim.run(commands[:start], PERIOD_S)
    reached = sim.state.copy()
    print(f"the first {solved_s:g} s of the first move, from the same state; reference Radau at rtol 1e-10", flush=True)
    reference = Solved(sim, "Radau", 1e-10).run(commands[rows], PERIOD_S)
    bare = SimulatedRig(load_rig("ornl_testbed").rig)
    bare.parameters.values[C.SENSORS] = 0.0

    def in_kernel() -> float:
        began = time.process_time()
        for _ in range(KERNEL_RUNS):
            bare.state[:] = reached
            bare.run(commands[rows], PERIOD_S)
        return (time.process_time() - began) / KERNEL_RUNS

    took = statistics.median(in_kernel() for _ in range(SOLVER_TURNS))
    own, lsoda = _worst({name: values[rows] for name, values in kernel.items()}, reference), []
    _line(_BARE, solved_s / took, own)
    for solver, rtol in SOLVERS:
        way, spent, ratios = Solved(sim, solver, rtol), [], []
        for _ in range(SOLVER_TURNS):
            sim.state[:], way.calls, began = reached, 0, time.process_time()
            signals = way.run(commands[rows], PERIOD_S)
            spent.append(time.process_time() - began)
            ratios.append(spent[-1] / in_kernel())
        name = f"scipy {solver}, rtol {rtol:g}, {way.calls / len(signals['tip.deflection']):.0f} rates/ms"
        error = _worst(signals, reference)
        _line(name, solved_s / statistics.median(spent), error, ratios)
        lsoda += [(error, statistics.median(ratios))] if solver == "LSODA" else []
    print(f"LSODA at the kernel's error, between its tolerances: kernel {_at(own, lsoda):.0f} times faster", flush=True)


def _at(error: float, measured: Sequence[tuple[float, float]]) -> float:
    """How many times longer LSODA takes where it errs as much: straight between what was measured, over the error's logarithm."""
    errors, ratios = zip(*sorted(measured), strict=True)
    return float(np.interp(np.log(error), np.log(errors), ratios))


def _line(name: str, speed: float | None, error: float, slower: Sequence[float] = ()) -> None:
    times = "" if speed is None else f"{speed:9.3g} x real time"
    beside = f"   kernel {statistics.median(slower):.0f} times faster ({min(slower):.0f} to {max(slower):.0f})" if slower else ""
    print(f"{name:44}{times:24} {error:9.2g} %{beside}", flush=True)


def _paper_line() -> Array:
    with tempfile.TemporaryDirectory() as folder:
        log = longreach.simulate("ornl_testbed", "paper_line", out=str(Path(folder) / "line.mcap"))
    return np.column_stack([log.columns[f"{joint}.command_V"] for joint in ("rotary", "prismatic")])


def _from_start(sim: SimulatedRig, commands: Array, step_s: float | None) -> Signals:
    p = sim.parameters.values
    shipped = float(p[C.STEP])
    sim.reset()
    p[C.STEP] = shipped if step_s is None else step_s
    signals = sim.run(commands, PERIOD_S)
    p[C.STEP] = shipped
    return signals


def _c_run(plant: CPlant, sim: SimulatedRig, commands: Array) -> Signals:
    sim.reset()
    return plant.run(commands, float(sim.parameters.values[C.STEP]))


def _in_turns(ways: dict[str, Callable[[], Signals]]) -> dict[str, list[float]]:
    seconds: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(TURNS):
        for name, way in ways.items():
            began = time.process_time()
            way()
            seconds[name].append(time.process_time() - began)
    return seconds


def _worst(signals: Signals, reference: Signals) -> float:
    # tip and pressures, and the positions they hang on
    return max(100 * float(np.abs(signals[name] - reference[name]).max() / np.ptp(reference[name])) for name in COLUMNS)


if __name__ == "__main__":
    main()
