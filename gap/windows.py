"""Simulate in short windows and compare: memory is carried from the log's start, what is not known at a window's start is marginalised.

e = (measured − simulated) / noise. With J₀ the sensitivity to the window's initial state s₀ and S₀ its prior covariance, e is replaced by
e − J₀ ŝ and the residual of the prior, ŝ = (J₀ᵀJ₀ + S₀⁻¹)⁻¹ J₀ᵀ e. All of this is linear in e, so it acts on columns of a Jacobian alike.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from scipy.signal import savgol_filter

from config.errors import LogError
from config.rig import Rig
from gap.measured import Array, Measured, bridged
from sim_backend.batch import TARGETS, WindowPlan, carry, quiet, restart
from sim_backend.layout import D_STRIDE, J_START, J_STRIDE, SLOTS, C, D, J, Vector, X
from sim_backend.parameters import Parameters
from sim_backend.plant import SimulatedRig
from sim_backend.rates import IMPOSED

SAMPLE_RATE_HZ = 350.0  # readings compared; commands act at the log's own rate
SLOPE_SPAN_S = 0.03  # span of the local parabola that gives velocities at a window's start
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
        moved = np.einsum("wkn,wn->wk", self.gain, e)
        return np.concatenate([e - np.einsum("wnk,wk->wn", self.sensitivity, moved), moved], axis=1)


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


def simulate(experiment: Experiment, vectors: Sequence[Vector]) -> list[Array]:
    """Readings of every parameter vector, windows × samples × channels each."""
    with ThreadPoolExecutor(experiment.workers) as pool:
        return list(pool.map(lambda p: _readings(experiment, p), vectors))


def residual(experiment: Experiment, readings: Array) -> Array:
    """(measured − simulated) / noise, windows × values; 0 where nothing was measured, huge where the simulation ran away."""
    e = (experiment.measured - np.nan_to_num(readings, nan=np.inf)) / experiment.sigma
    return np.where(np.isfinite(experiment.measured), np.clip(e, -_HUGE, _HUGE), 0.0).reshape(experiment.windows, -1)


def marginalised(experiment: Experiment, p: Vector) -> Projection:
    """The projection that takes out each window's unknown initial state, linearised at the parameters `p`."""
    p = _warmed(experiment, p)
    base, kept = carry(experiment.start, p, experiment.plan, keep=True)
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


def _readings(experiment: Experiment, p: Vector) -> Array:
    readings, _ = carry(experiment.start, _warmed(experiment, p), experiment.plan)
    return readings[:, :, experiment.columns]


def _warmed(experiment: Experiment, p: Vector) -> Vector:
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
    length = 2 * _slope_rows(log.period_s) + 1
    for name, (value, rate) in places.items():
        if name in log.channels:
            read = bridged(log.channels[name].values)
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
