"""Sensors, servo and log of the hidden machine: everything between its true signals and the rows of a CSV file."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tests.blind.truth.plant import SIGNALS, advance, signals

Array = NDArray[np.float64]

CHANNELS = (
    "rotary.position", "prismatic.position", "rotary.supply_pressure", "prismatic.supply_pressure", "rotary.return_pressure",
    "prismatic.return_pressure", "tip.acceleration", "tip.deflection", "rotary.pressure_a", "rotary.pressure_b",
    "prismatic.pressure_a", "prismatic.pressure_b",
)  # fmt: skip


class Sensors(NamedTuple):
    """One entry a channel."""

    bandwidth_Hz: Array
    delay_s: Array
    polarity: Array
    scale: Array
    offset: Array
    noise: Array
    noise_memory: Array  # share of the noise that the next sample keeps
    step: Array  # coarse steps of the reading; 0: none
    low: Array
    high: Array
    resolution: Array


class Servo(NamedTuple):
    """Proportional with velocity feed-forward; limits of the command."""

    gain: Array
    feedforward: Array
    limit: Array


@njit(cache=True)
def reading(history, k, period, white, noise, s, out):
    """One row of readings at cycle k from the lagged true values `history`; `noise` is carried on."""
    for c in range(out.shape[0]):
        delay = min(s.delay_s[c] / period, k * 1.0)
        whole = int(np.floor(delay))
        part = delay - whole
        value = history[k - whole, c]
        if part > 0.0:
            value = (1.0 - part) * value + part * history[k - whole - 1, c]
        keep = s.noise_memory[c]
        noise[c] = keep * noise[c] + np.sqrt(1.0 - keep * keep) * white[c]
        value = s.polarity[c] * s.scale[c] * value + s.offset[c] + s.noise[c] * noise[c]
        if s.step[c] > 0.0:
            value = s.step[c] * np.rint(value / s.step[c])
        value = min(max(value, s.low[c]), s.high[c])
        out[c] = s.resolution[c] * np.rint(value / s.resolution[c])


@njit(cache=True)
def lagged(history, k, period, true, s):
    """Append the true values behind each sensor's first-order lag."""
    for c in range(true.shape[0]):
        if k == 0 or s.bandwidth_Hz[c] == 0.0:
            history[k, c] = true[c]
        else:
            keep = np.exp(-2.0 * np.pi * s.bandwidth_Hz[c] * period)
            history[k, c] = true[c] + keep * (history[k - 1, c] - true[c])


@njit(cache=True)
def run(y, play, reference, periods, temperatures, white, m, s, servo, readings, commands):
    """Close the loop over all rows. reference: rows × (position 0, rate 0, position 1, rate 1); fills readings and commands."""
    rows = reference.shape[0]
    history, true, noise = np.zeros((rows, SIGNALS)), np.zeros(SIGNALS), np.zeros(SIGNALS)
    wanted = np.zeros(2)
    t = 0.0
    for k in range(rows):
        for n in range(2):
            wanted[n] = y[16 + 2 * n]
        signals(y, t, wanted, temperatures[k], m, true)
        lagged(history, k, periods[k], true, s)
        reading(history, k, periods[k], white[k], noise, s, readings[k])
        for n in range(2):
            command = servo.gain[n] * (reference[k, 2 * n] - readings[k, n]) + servo.feedforward[n] * reference[k, 2 * n + 1]
            commands[k, n] = min(max(command, -servo.limit[n]), servo.limit[n])
        advance(y, play, commands, k, t, periods[k], temperatures[k], m)
        t += periods[k]
