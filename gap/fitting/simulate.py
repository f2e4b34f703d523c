"""Simulate parameters through the windows of a log: through the whole log, or from states that an earlier simulation kept."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gap.data.measured import Array
from gap.data.strata import chosen
from gap.data.windows import Experiment, Memory, velocities
from sim_backend.kernel.batch import carry
from sim_backend.memory.layout import J_START, J_STRIDE, SLOTS, C, H, J, Vector, X

LEAD_IN_S = 0.15  # from a kept state to the window: spools, chambers, delay lines and bristles have forgotten other constants
_HUGE = 1e6  # a residual that leaves no doubt


def some(experiment: Experiment, numbers: NDArray[np.int64]) -> Experiment:
    """The experiment with these windows only; each run of neighbours is reached from a kept state, a little before its first window."""
    if len(numbers) == experiment.windows:
        return experiment
    plan = experiment.plan
    starts = plan.starts[numbers]
    apart = np.concatenate([[True], np.diff(starts) > plan.rows])
    entries = np.where(apart, starts - round(LEAD_IN_S / plan.period_s), -1)
    entries[0] = max(entries[0], 0)
    thinned = replace(plan, starts=starts, entries=entries)
    return replace(experiment, plan=thinned, measured=experiment.measured[numbers], whole=plan)


def of_every_regime(experiments: Sequence[Experiment]) -> list[Experiment]:
    """Windows of every regime of each log."""
    numbers = chosen([velocities(e) for e in experiments])
    return [some(e, n) for e, n in zip(experiments, numbers, strict=True)]


def chosen_windows(experiments: Sequence[Experiment], p: Vector) -> list[Experiment]:
    """The same, with what they remember with the parameters `p`."""
    return [remembering(e, p) for e in of_every_regime(experiments)]


def remembering(experiment: Experiment, p: Vector) -> Experiment:
    """The experiment with what its chosen windows remember renewed by one simulation of the whole log."""
    if experiment.whole is None or experiment.plan.entries is None:
        return experiment
    entries = experiment.plan.entries
    rows = np.union1d(experiment.whole.starts, entries[entries >= 0])
    p = warmed(experiment, p)
    _, kept = carry(experiment.start, p, replace(experiment.whole, starts=rows, rows=1, every=1), keep=True)
    states = np.zeros((experiment.windows, kept.shape[1]))
    states[entries >= 0] = kept[np.searchsorted(rows, entries[entries >= 0])]
    return replace(experiment, memory=Memory(p, states))


def simulate(experiment: Experiment, vectors: Sequence[Vector]) -> list[Array]:
    """Readings of every parameter vector, windows × samples × channels each."""
    return on_logs([experiment], vectors)[0]


def on_logs(experiments: Sequence[Experiment], vectors: Sequence[Vector]) -> list[list[Array]]:
    """The same on several logs, one list a log; a single vector keeps as many threads busy as there are logs."""
    runs = [(n, k) for n in range(len(experiments)) for k in range(len(vectors))]
    jobs = [(n, k, part) for n, k in runs for part in _parts(experiments[n], vectors[k], len(runs))]
    with ThreadPoolExecutor(max((e.workers for e in experiments), default=1)) as pool:
        done = list(pool.map(lambda job: _readings(experiments[job[0]], vectors[job[1]], job[2]), jobs))
    groups: list[list[list[Array]]] = [[[] for _ in vectors] for _ in experiments]
    for (n, k, _), readings in zip(jobs, done, strict=True):
        groups[n][k].append(readings)
    return [[np.concatenate(parts) for parts in log] for log in groups]


def kept(experiment: Experiment, p: Vector) -> tuple[Array, Array]:
    """Readings of all sensors with (warmed) parameters, and the state of every window's start."""
    with ThreadPoolExecutor(experiment.workers) as pool:
        done = list(pool.map(lambda part: _carried(experiment, p, part, keep=True), _parts(experiment, p, 1)))
    return np.concatenate([readings for readings, _ in done]), np.concatenate([states for _, states in done])


def residual(experiment: Experiment, readings: Array) -> Array:
    """(measured − simulated) / noise, windows × values; 0 where nothing was measured, huge where the simulation ran away."""
    e = (experiment.measured - np.nan_to_num(readings, nan=np.inf)) / experiment.sigma
    return np.where(np.isfinite(experiment.measured), np.clip(e, -_HUGE, _HUGE), 0.0).reshape(experiment.windows, -1)


def _parts(experiment: Experiment, p: Vector, runs: int) -> list[slice]:
    """The windows cut into as many parts as there are idle threads, where fewer runs than threads are made at a time; only windows with a
    kept state can begin a part."""
    everything = slice(0, experiment.windows)
    if runs >= experiment.workers or experiment.plan.entries is None or experiment.memory is None:
        return [everything]
    if not _remembers_alike(warmed(experiment, p), experiment.memory.p):
        return [everything]
    firsts = np.flatnonzero(experiment.plan.entries >= 0)
    ideal = np.arange(1, experiment.workers) * experiment.windows / experiment.workers
    cuts = sorted({int(firsts[np.argmin(np.abs(firsts - at))]) for at in ideal} - {0})
    return [slice(a, b) for a, b in pairwise([0, *cuts, experiment.windows])]


def _readings(experiment: Experiment, p: Vector, part: slice) -> Array:
    readings, _ = _carried(experiment, warmed(experiment, p), part)
    return readings[:, :, experiment.columns]


def _carried(experiment: Experiment, p: Vector, part: slice, keep: bool = False) -> tuple[Array, Array]:
    """Simulate (warmed) parameters into the windows of one part, from kept states where these are what `p` would remember."""
    plan, memory = experiment.plan, experiment.memory
    if memory is None or plan.entries is None:
        return carry(experiment.start, p, plan, keep)
    if not _remembers_alike(p, memory.p):
        readings, kept = carry(experiment.start, p, plan, keep)
        return readings[part], kept[part] if keep else kept
    states = memory.states[part].copy()
    states[:, H.RESERVOIR : H.OIL + 1] += p[C.INITIAL_TEMPERATURE] - memory.p[C.INITIAL_TEMPERATURE]
    states[:, X.SUPPLY_PRESSURE] += p[C.SUPPLY_PRESSURE] - memory.p[C.SUPPLY_PRESSURE]
    return carry(experiment.start, p, replace(plan, starts=plan.starts[part], entries=plan.entries[part]), keep, states)


def _remembers_alike(p: Vector, other: Vector) -> bool:
    """Whether what both remember longer than the lead-in is the same: backlash, accumulator. (Hysteresis follows from the commands.)"""
    slots = [J_START + slot * J_STRIDE + J.GAP for slot in range(SLOTS)]
    numbers = [*slots, C.INVERSE_GAS_VOLUME, C.PUMP_FLOW]
    return bool(np.array_equal(p[numbers], other[numbers]))


def warmed(experiment: Experiment, p: Vector) -> Vector:
    """The parameters with the oil as warm as this log found it."""
    warm = p.copy()
    warm[C.INITIAL_TEMPERATURE] += experiment.warmer_K
    return warm
