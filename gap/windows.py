"""Simulate in short windows and compare: memory is carried from the log's start, what is not known at a window's start is marginalised.

e = (measured − simulated) / noise. With J₀ the sensitivity to the window's initial state s₀ and S₀ its prior covariance, e is replaced by
e − J₀ ŝ and the residual of the prior, ŝ = (J₀ᵀJ₀ + S₀⁻¹)⁻¹ J₀ᵀ e. All of this is linear in e, so it acts on columns of a Jacobian alike.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from config.errors import LogError
from config.rig import Rig
from gap.measured import Array, Measured, bridged
from sim_backend.batch import TARGETS, WindowPlan, carry, quiet, restart
from sim_backend.layout import D_STRIDE, J_START, J_STRIDE, SLOTS, C, D, H, J, Vector, X
from sim_backend.parameters import Parameters
from sim_backend.plant import SimulatedRig
from sim_backend.rates import IMPOSED

SAMPLE_RATE_HZ = 350.0  # readings compared; commands act at the log's own rate
IMPOSED_ROWS = 10  # at least on either side where the velocity is an input: its noise would count as force
SLOPE_SPAN_S = 0.03  # span of the local parabola that gives velocities at a window's start
LEAD_IN_S = 0.15  # from a kept state to the window: spools, chambers, delay lines and bristles have forgotten other constants
BURN_IN_S = 0.3  # the carried states forget how the simulation was started
LEAST_WINDOWS = 6
_HUGE = 1e6  # a residual that leaves no doubt

# Standard deviation of each state at a window's start, and by how much it is moved for its sensitivity. Positions and velocities come
# from the measurement; pressures, friction and modes are the model's own, disturbed by that correction.
_POSITION_SD, _VELOCITY_SD, _PRESSURE_SD, _SHAPE_SD, _SHAPE_RATE_SD = 5e-5, 4e-3, 1e4, 1e-3, 5e-2


@dataclass(frozen=True, slots=True)
class StartState:
    """One marginalised state: its number in the kernel's state vector and its prior standard deviation."""

    number: int
    sd: float


@dataclass(frozen=True, slots=True)
class Memory:
    """States of a simulation of the whole log with parameters `p` (warmed), at the windows' entry rows: windows × states."""

    p: Vector
    states: Array


@dataclass(frozen=True, slots=True)
class Experiment:
    """One log cut into windows. `measured`: windows × samples × channels (NaN: not measured), in the channels' units."""

    log: Measured
    plan: WindowPlan
    start: Vector
    columns: tuple[int, ...]  # of the compared channels among the plant's sensors
    measured: Array
    sigma: Array  # noise of each channel
    velocity_sd: Mapping[int, float]  # of each slot, at a window's start
    warmer_K: float  # oil at the log's start against the rig file
    workers: int = 1  # threads that simulate
    whole: WindowPlan | None = None  # every window of the log, where this experiment has chosen some
    memory: Memory | None = None  # what these windows are reached from instead of through the whole log

    @property
    def windows(self) -> int:
        return len(self.plan.starts)

    @property
    def times_s(self) -> Array:
        """Time of every sample, windows × samples."""
        rows = self.plan.starts[:, None] + self.plan.every * np.arange(self.plan.samples)[None, :]
        return np.asarray(self.log.t_s[rows])


@dataclass(frozen=True, slots=True)
class Projection:
    """What marginalising the initial states does to a residual; sensitivities in units of the prior, windows × values × states."""

    sensitivity: Array
    gain: Array  # windows × states × values

    def apply(self, e: Array) -> Array:
        """windows × values → windows × (values + states): what is left, then the cost of the initial states."""
        moved = np.matmul(self.gain, e[:, :, None])
        left = e - np.matmul(self.sensitivity, moved)[:, :, 0]
        return np.concatenate([left, moved[:, :, 0]], axis=1)

    def apply_all(self, columns: Array) -> Array:
        """numbers × windows × values → numbers × windows × (values + states)."""
        e = columns.transpose(1, 2, 0)
        moved = np.matmul(self.gain, e)
        return np.concatenate([e - np.matmul(self.sensitivity, moved), moved], axis=1).transpose(2, 0, 1)


def default_window_s(rig: Rig) -> float:
    """About two periods of the slower link modes for an arm, else a fifth of a second."""
    return 0.4 if rig.arm.kind == "rotary_prismatic" else 0.2


def prepare(log: Measured, rig: Rig, sigma: Mapping[str, float], window_s: float, channels: Sequence[str], workers: int = 1) -> Experiment:
    """Cut one log into adjoining windows; windows with missing rows are left out. LogError when too few remain."""
    rows = max(round(window_s / log.period_s), 8)
    every = max(round(1 / (SAMPLE_RATE_HZ * log.period_s)), 1)
    first = max(round(BURN_IN_S / log.period_s), _slope_rows(log.period_s))
    starts = np.arange(first, log.rows - rows - _slope_rows(log.period_s), rows)
    whole = np.array([not log.missing[s - 1 : s + rows].any() for s in starts], dtype=bool)
    starts = starts[whole].astype(np.int64) if starts.size else starts
    if len(starts) < LEAST_WINDOWS:
        what = "the log has too few whole windows to compare"
        raise LogError(what, value=len(starts), limit=LEAST_WINDOWS, where=str(log.path), next_step="Log a longer maneuver without gaps.")
    samples = starts[:, None] + every * np.arange((rows - 1) // every + 1)[None, :]
    blank = np.full(log.rows, np.nan)
    measured = np.stack([log.channels[name].values[samples] if name in log.channels else blank[samples] for name in channels], axis=2)
    parameters = Parameters(rig)
    plan = WindowPlan(_slot_commands(log, rig, parameters), starts, rows, every, log.period_s, _targets(log, parameters))
    columns = tuple(parameters.sensors[name] for name in channels)
    noise = np.array([sigma[name] for name in channels])
    return Experiment(
        log, plan, _rest(log, rig), columns, measured, noise, _velocity_sd(log, sigma, parameters), _warmer(log, rig), workers
    )


def velocities(experiment: Experiment) -> Array:
    """Measured velocities in every window, windows × samples × slots; NaN where not measured."""
    rows = experiment.plan.starts[:, None] + experiment.plan.every * np.arange(experiment.plan.samples)[None, :]
    return np.asarray(experiment.plan.targets[rows][:, :, SLOTS : 2 * SLOTS])


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
    jobs = [(k, part) for k, p in enumerate(vectors) for part in _parts(experiment, p, len(vectors))]
    with ThreadPoolExecutor(experiment.workers) as pool:
        done = list(pool.map(lambda job: _readings(experiment, vectors[job[0]], job[1]), jobs))
    groups: list[list[Array]] = [[] for _ in vectors]
    for (k, _), readings in zip(jobs, done, strict=True):
        groups[k].append(readings)
    return [np.concatenate(group) for group in groups]


def residual(experiment: Experiment, readings: Array) -> Array:
    """(measured − simulated) / noise, windows × values; 0 where nothing was measured, huge where the simulation ran away."""
    e = (experiment.measured - np.nan_to_num(readings, nan=np.inf)) / experiment.sigma
    return np.where(np.isfinite(experiment.measured), np.clip(e, -_HUGE, _HUGE), 0.0).reshape(experiment.windows, -1)


def marginalised(experiment: Experiment, p: Vector) -> Projection:
    """The projection that takes out each window's unknown initial state, linearised at the parameters `p`."""
    p = warmed(experiment, p)
    base, kept = _carried(experiment, p, slice(0, experiment.windows), keep=True)
    states = start_states(p, experiment)
    with ThreadPoolExecutor(experiment.workers) as pool:
        moved = list(pool.map(lambda s: restart(kept, p, experiment.plan, s.number, s.sd), states))
    there = np.isfinite(experiment.measured)
    columns = [np.where(there, ((m - base)[:, :, experiment.columns]) / experiment.sigma, 0.0) for m in moved]
    values = experiment.measured[0].size
    blank = np.empty((experiment.windows, values, 0))
    a = np.stack([np.nan_to_num(column).reshape(experiment.windows, -1) for column in columns], axis=2) if columns else blank
    gain = np.linalg.solve(np.einsum("wnk,wnl->wkl", a, a) + np.eye(a.shape[2]), a.transpose(0, 2, 1))
    return Projection(a, gain)


def start_states(p: Vector, experiment: Experiment) -> list[StartState]:
    """Which initial states are marginalised: motion of every joint, its pressures, and the link's shapes when it bends."""
    states = []
    for slot in range(SLOTS):
        kind = p[J_START + slot * J_STRIDE + J.KIND]
        if kind in (0.0, IMPOSED):
            continue
        s = slot * D_STRIDE
        states += [StartState(s + D.POSITION, _POSITION_SD), StartState(s + D.VELOCITY, experiment.velocity_sd[slot])]
        if kind == 1.0:
            states += [StartState(s + D.PRESSURE_A, _PRESSURE_SD), StartState(s + D.PRESSURE_B, _PRESSURE_SD)]
    if p[C.ARM] > 0.0 and p[C.BENDING_STIFFNESS] > 0.0:
        states += [StartState(int(k), _SHAPE_SD) for k in (X.SHAPE_1, X.SHAPE_2)]
        states += [StartState(int(k), _SHAPE_RATE_SD) for k in (X.SHAPE_1_RATE, X.SHAPE_2_RATE)]
    return states


def _parts(experiment: Experiment, p: Vector, vectors: int) -> list[slice]:
    """The windows cut into as many parts as there are idle threads; only windows with a kept state can begin a part."""
    everything = slice(0, experiment.windows)
    if vectors >= experiment.workers or experiment.plan.entries is None:
        return [everything]
    if experiment.memory is None or not _remembers_alike(p, experiment.memory.p):
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
    """Whether what both remember longer than the lead-in is the same: hysteresis, backlash, accumulator."""
    slots = [J_START + slot * J_STRIDE + item for slot in range(SLOTS) for item in (J.HYSTERESIS, J.GAP)]
    numbers = [*slots, C.INVERSE_GAS_VOLUME, C.PUMP_FLOW]
    return bool(np.array_equal(p[numbers], other[numbers]))


def warmed(experiment: Experiment, p: Vector) -> Vector:
    """The parameters with the oil as warm as this log found it."""
    warm = p.copy()
    warm[C.INITIAL_TEMPERATURE] += experiment.warmer_K
    return warm


def _slope_rows(period_s: float) -> int:
    return max(round(0.5 * SLOPE_SPAN_S / period_s), 2)


def _velocity_sd(log: Measured, sigma: Mapping[str, float], parameters: Parameters) -> dict[int, float]:
    """Of the velocity at a window's start: at least three standard deviations of what the parabola makes of the position's noise."""
    half = _slope_rows(log.period_s)
    spread = 3.0 / (log.period_s * np.sqrt(half * (half + 1) * (2 * half + 1) / 3))
    return {slot: max(_VELOCITY_SD, float(sigma[f"{joint}.position"] * spread)) for joint, slot in parameters.slots.items()}


def _slot_commands(log: Measured, rig: Rig, parameters: Parameters) -> Array:
    commands = np.zeros((log.rows, SLOTS))
    for number, joint in enumerate(rig.joints):
        commands[:, parameters.slots[joint]] = log.commands_V[:, number]
    return commands


def _targets(log: Measured, parameters: Parameters) -> Array:
    """Measured positions, velocities, accelerations and tip deflection at every row, from a local parabola; NaN next to rows that are
    missing."""
    targets = np.full((log.rows, TARGETS), np.nan)
    places = {f"{joint}.position": (slot, 2 + slot) for joint, slot in parameters.slots.items()} | {"tip.deflection": (4, 5)}
    imposed = {slot for slot in range(SLOTS) if parameters.values[J_START + slot * J_STRIDE + J.KIND] == IMPOSED}
    for name, (value, rate) in places.items():
        if name in log.channels:
            half = max(_slope_rows(log.period_s), IMPOSED_ROWS if value in imposed else 0)
            length, read = 2 * half + 1, bridged(log.channels[name].values)
            targets[:, value] = savgol_filter(read, length, 2, mode="nearest")
            targets[:, rate] = savgol_filter(read, length, 2, deriv=1, delta=log.period_s, mode="nearest")
            if value < SLOTS:
                targets[:, 6 + value] = savgol_filter(read, length, 2, deriv=2, delta=log.period_s, mode="nearest")
    return targets


def _rest(log: Measured, rig: Rig) -> Vector:
    """The plant at rest where the log begins."""
    simulated = SimulatedRig(rig)
    positions = []
    for joint in rig.joints:
        values = log.channels[f"{joint}.position"].values
        assert rig.plant is not None
        low, high = rig.plant.joints[joint].travel
        positions.append(float(np.clip(values[np.isfinite(values)][0], low, high)))
    simulated.parameters.values[:] = quiet(simulated.parameters)
    simulated.reset(positions)
    return simulated.state.copy()


def _warmer(log: Measured, rig: Rig) -> float:
    plant = rig.plant
    assert plant is not None
    sensor = plant.sensors.get("reservoir_temperature")
    if log.oil_C is None or plant.oil is None or sensor is None:
        return 0.0
    return log.oil_C - sensor.bias - plant.oil.initial_temperature_C
