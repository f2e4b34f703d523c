"""What the balance equations of one log are made of, at every row: signals, rates, commands, and numbers of the rig file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from config.schema.rig import Rig
from gap.data.at_stop import at_stop
from gap.data.measured import Array, Measured
from gap.data.uniform_grid import bridged
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import J, Vector
from sim_backend.physics.link import mass_and_bias
from sim_backend.physics.valve import spool_command


@dataclass(frozen=True, slots=True)
class LogSignals:
    """What the equations are made of, at every row."""

    rig: Rig
    p: Vector
    slots: Mapping[str, int]
    signals: Mapping[str, Array]
    velocity: Mapping[str, Array]
    commands_V: Mapping[str, Array]
    pressed: Mapping[str, NDArray[np.bool_]]  # on the end of its travel
    sigma: Mapping[str, float]
    period_s: float


class Inertia(IntEnum):
    """Columns of `mass_matrix`: what mass_and_bias returns for (θ, L, η₁, η₂), SI."""

    TURN = 0
    TURN_EXTEND = 1
    TURN_BEND_1 = 2
    TURN_BEND_2 = 3
    EXTEND = 4
    EXTEND_BEND_1 = 5
    EXTEND_BEND_2 = 6
    BEND_1 = 7
    BEND_1_BEND_2 = 8
    BEND_2 = 9
    TURN_BIAS = 10
    EXTEND_BIAS = 11
    BEND_1_BIAS = 12
    BEND_2_BIAS = 13


def log_signals(log: Measured, rig: Rig, sigma: Mapping[str, float]) -> LogSignals:
    parameters = Parameters(rig)
    signals = {name: bridged(channel.values) for name, channel in log.channels.items()}
    velocity = {joint: rate(signals[f"{joint}.position"], log.period_s) for joint in rig.joints}
    commands = {joint: log.commands_V[:, number] for number, joint in enumerate(rig.joints)}
    pressed = dict(zip(rig.joints, at_stop(log, rig).T, strict=True))
    return LogSignals(rig, parameters.values, parameters.slots, signals, velocity, commands, pressed, sigma, log.period_s)


def rate(values: Array, period_s: float) -> Array:
    """A smoothed rate (NaN next to the ends), for the sign of friction and for Coriolis terms; inertia never sees it."""
    half = max(round(0.015 / period_s), 1)
    found = np.full(len(values), np.nan)
    smooth = np.convolve(values, np.ones(2 * half + 1) / (2 * half + 1), mode="valid")
    found[half:-half] = np.gradient(smooth, period_s)
    return found


def spool(log: LogSignals, joint: str, j: int) -> Array:
    """Opening asked for at every row: bias, hysteresis and saturation as in the rig file; its lag is not looked at."""
    play, found = 0.0, np.empty(len(log.commands_V[joint]))
    shift = round(log.p[j + J.DELAY] / log.period_s)
    for row, command in enumerate(log.commands_V[joint]):
        found[row], play = spool_command(command, play, log.p, j, 40.0)
    return np.concatenate([np.full(shift, found[0]), found[: len(found) - shift]])


def mass_matrix(log: LogSignals, starts: NDArray[np.int64], rows: int) -> Array:
    """Mass matrix and biases of the arm in the middle of every support (supports × columns of Inertia)."""
    first, second = log.velocity["rotary"], log.velocity["prismatic"]
    length = log.signals["prismatic.position"]
    tip = log.signals.get("tip.deflection", np.zeros_like(length))
    tip_d = rate(tip, log.period_s)
    middle = starts + rows // 2
    return np.array([mass_and_bias(first[k], length[k], second[k], tip[k], 0.0, tip_d[k], 0.0, log.p) for k in middle])
