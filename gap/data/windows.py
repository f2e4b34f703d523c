"""A log cut into short windows: commands, measured values and the measured motion from which every window starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from config.errors import LogError
from config.schema.rig import Rig
from gap.data.at_stop import at_stop
from gap.data.channel_check import clipped
from gap.data.local_motion import local_motion, rate_noise
from gap.data.measured import Array, Measured
from gap.data.uniform_grid import bridged
from sim_backend.kernel.batch import WindowPlan, quiet
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import J_START, J_STRIDE, SLOTS, TARGETS, J, Kind, Target, Vector
from sim_backend.plant import SimulatedRig

SAMPLE_RATE_HZ = 350.0  # readings compared; commands act at the log's own rate
IMPOSED_ROWS = 10  # at least on either side where the velocity is an input: its noise would count as force
SLOPE_SPAN_S = 0.03  # longest span of the local polynomial that gives velocities at a window's start
LEAST_WINDOWS = 6  # in all fit logs, and in all hold-out logs
BURN_IN_S = 0.3  # the carried states forget how the simulation was started
SHAPE_RATE_SD = 5e-2  # of the link's shapes (m/s)
_VELOCITY_SD = 4e-3  # at least, of the velocity at a window's start (rad/s or m/s)


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


def default_window_s(rig: Rig) -> float:
    """About two periods of the slower link modes for an arm, else a fifth of a second."""
    return 0.4 if rig.arm.kind == "rotary_prismatic" else 0.2


def prepare(log: Measured, rig: Rig, sigma: Mapping[str, float], window_s: float, channels: Sequence[str], workers: int = 1) -> Experiment:
    """Cut one log into adjoining windows, without those in which rows are missing, a joint is pressed on its stop or its position is cut
    off. A log may have none left: `left_in` judges all logs together."""
    rows = max(round(window_s / log.period_s), 8)
    every = max(round(1 / (SAMPLE_RATE_HZ * log.period_s)), 1)
    first = max(round(BURN_IN_S / log.period_s), _slope_rows(log.period_s))
    starts = np.arange(first, log.rows - rows - _slope_rows(log.period_s), rows)
    cut = _cut_off(log, rig)
    useless = _useless(log, rig, cut)
    whole = np.array([not useless[s - 1 : s + rows].any() for s in starts], dtype=bool)
    starts = starts[whole].astype(np.int64)
    samples = starts[:, None] + every * np.arange((rows - 1) // every + 1)[None, :]
    blank = np.full(log.rows, np.nan)
    columns = [np.where(cut[name], np.nan, log.channels[name].values) if name in log.channels else blank for name in channels]
    measured = np.stack([column[samples] for column in columns], axis=2)
    parameters = Parameters(rig)
    velocity_sd = _velocity_sd(log, sigma, parameters)
    targets = _targets(log, parameters, sigma, velocity_sd)
    plan = WindowPlan(_slot_commands(log, rig, parameters), starts, rows, every, log.period_s, targets)
    sensors = tuple(parameters.sensors[name] for name in channels)
    noise = np.array([sigma[name] for name in channels])
    return Experiment(log, plan, _rest(log, rig), sensors, measured, noise, velocity_sd, _warmer(log, rig), workers)


def left_in(experiments: Sequence[Experiment], option: str) -> list[Experiment]:
    """The logs that have windows; none of none. LogError when all together have too few for a verdict; `option`: how they were given."""
    windows = sum(experiment.windows for experiment in experiments)
    if experiments and windows < LEAST_WINDOWS:
        what = "too few windows are left: rows are missing, at a stop or cut off, or the logs are too short"
        span = f"{experiments[0].plan.rows * experiments[0].plan.period_s:.2g} s"
        advice = f"Add logs of further motion ({option} LOG, may be repeated), or shorter windows (--window; now {span})."
        where = ", ".join(str(experiment.log.path) for experiment in experiments)
        raise LogError(what, value=windows, limit=LEAST_WINDOWS, unit="windows", where=where, next_step=advice)
    return [experiment for experiment in experiments if experiment.windows]


def _cut_off(log: Measured, rig: Rig) -> dict[str, NDArray[np.bool_]]:
    """Channel → rows in which it was cut off before it was logged; of channels that this model has."""
    sensors = rig.plant.sensors if rig.plant else {}
    return {name: clipped(channel, sensors[name]) for name, channel in log.channels.items() if name in sensors}


def _useless(log: Measured, rig: Rig, cut: Mapping[str, NDArray[np.bool_]]) -> NDArray[np.bool_]:
    """Rows that no window may hold."""
    positions = [rows for name, rows in cut.items() if name.endswith(".position")]
    return np.asarray(np.any([log.missing, at_stop(log, rig).any(axis=1), *positions], axis=0))


def velocities(experiment: Experiment) -> Array:
    """Measured velocities in every window, windows × samples × slots; NaN where not measured."""
    rows = experiment.plan.starts[:, None] + experiment.plan.every * np.arange(experiment.plan.samples)[None, :]
    return np.asarray(experiment.plan.targets[rows][:, :, Target.VELOCITY : Target.VELOCITY + SLOTS])


def _slope_rows(period_s: float) -> int:
    return max(round(0.5 * SLOPE_SPAN_S / period_s), 2)


def _velocity_sd(log: Measured, sigma: Mapping[str, float], parameters: Parameters) -> dict[int, float]:
    """Of the velocity at a window's start: at least three standard deviations of what the parabola makes of the position's noise."""
    spread = 3.0 * rate_noise(2, _slope_rows(log.period_s), log.period_s)
    return {slot: max(_VELOCITY_SD, float(sigma[f"{joint}.position"] * spread)) for joint, slot in parameters.slots.items()}


def _slot_commands(log: Measured, rig: Rig, parameters: Parameters) -> Array:
    commands = np.zeros((log.rows, SLOTS))
    for number, joint in enumerate(rig.joints):
        commands[:, parameters.slots[joint]] = log.commands_V[:, number]
    return commands


def _targets(log: Measured, parameters: Parameters, sigma: Mapping[str, float], velocity_sd: Mapping[int, float]) -> Array:
    """Measured positions, velocities, accelerations and tip deflection at every row; NaN next to rows that are missing."""
    targets = np.full((log.rows, TARGETS), np.nan)
    half = _slope_rows(log.period_s)
    for joint, slot in parameters.slots.items():
        read = bridged(log.channels[f"{joint}.position"].values) if f"{joint}.position" in log.channels else None
        if read is None:
            continue
        if parameters.values[J_START + slot * J_STRIDE + J.KIND] == Kind.IMPOSED:
            motion = _smooth(read, log.period_s, max(half, IMPOSED_ROWS))
        else:
            motion = local_motion(read, sigma[f"{joint}.position"], log.period_s, half, velocity_sd[slot] / 3.0)
        for column, values in zip((Target.POSITION, Target.VELOCITY, Target.ACCELERATION), motion, strict=True):
            targets[:, column + slot] = values
    if "tip.deflection" in log.channels:
        read, noise = bridged(log.channels["tip.deflection"].values), sigma["tip.deflection"]
        bent, rate, _ = local_motion(read, noise, log.period_s, half, SHAPE_RATE_SD / 3.0)
        targets[:, Target.TIP_DEFLECTION], targets[:, Target.TIP_DEFLECTION_RATE] = bent, rate
    return targets


def _smooth(read: Array, period_s: float, half: int) -> tuple[Array, Array, Array]:
    """Motion that is imposed at every row: a parabola of one length, since what is rough here would be force."""
    found = [savgol_filter(read, 2 * half + 1, 2, deriv=k, delta=period_s, mode="nearest") for k in range(3)]
    return found[0], found[1], found[2]


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
