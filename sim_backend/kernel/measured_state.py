"""States put where a measurement says they are, with what goes with them: the sensors' lags and delay lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_backend.memory.compiled import released
from sim_backend.memory.layout import (
    D_STRIDE,
    J_START,
    J_STRIDE,
    RING,
    S_START,
    S_STRIDE,
    SENSOR_START,
    SENSOR_STRIDE,
    SLOTS,
    C,
    D,
    H,
    J,
    S,
    Target,
    TrueSignal,
    Vector,
    X,
)

Array = NDArray[np.float64]


@released
def _move_readings(x: Vector, p: Vector, signal: int, change: float) -> None:
    """Move the lag and delay line of the sensors of one signal with the state they measure."""
    for number in range(int(p[C.SENSORS])):
        if int(p[S_START + number * S_STRIDE + S.SIGNAL]) == signal:
            at = SENSOR_START + number * SENSOR_STRIDE
            x[at] += change
            for k in range(RING):
                x[at + 3 + k] += change


@released
def _turn_readings(x: Vector, p: Vector, signal: int, change: float, period_s: float) -> None:
    """Turn the delay lines of the sensors of one signal about now, with the rate of the state they measure: what a late sensor still has to
    show is where the state was with that rate."""
    for number in range(int(p[C.SENSORS])):
        q = S_START + number * S_STRIDE
        if int(p[q + S.SIGNAL]) == signal and p[q + S.DELAY] > 0.0:
            at = SENSOR_START + number * SENSOR_STRIDE
            newest = int(x[H.SAMPLE]) + RING
            for age in range(1, min(int(p[q + S.DELAY] / period_s) + 3, RING)):
                x[at + 3 + (newest - age) % RING] -= change * age * period_s


@released
def move(x: Vector, p: Vector, state: int, change: float, period_s: float) -> None:
    """Move one differential state, and what goes with it."""
    x[state] += change
    for slot in range(SLOTS):
        if state == slot * D_STRIDE + D.POSITION:
            x[slot * D_STRIDE + D.ACTUATOR_POSITION] += change
            _move_readings(x, p, TrueSignal.POSITION + slot, change)
            _move_readings(x, p, TrueSignal.SECOND_POSITION + slot, change)
        if state == slot * D_STRIDE + D.VELOCITY:
            x[slot * D_STRIDE + D.ACTUATOR_VELOCITY] += change
            _turn_readings(x, p, TrueSignal.POSITION + slot, change, period_s)
            _turn_readings(x, p, TrueSignal.SECOND_POSITION + slot, change, period_s)
    if state == X.SHAPE_1:
        _move_readings(x, p, TrueSignal.TIP_DEFLECTION, change)
    if state == X.SHAPE_1_RATE:
        _turn_readings(x, p, TrueSignal.TIP_DEFLECTION, change, period_s)


@released
def _true_motion(p: Vector, signal: int, targets: Array, row: int, columns: tuple[int, int], period_s: float) -> tuple[float, float]:
    """True value and rate at a row, as far as the model knows the sensor: what a late sensor shows later is true now."""
    factor, offset, shift = 1.0, 0.0, 0.0
    for number in range(int(p[C.SENSORS])):
        q = S_START + number * S_STRIDE
        if int(p[q + S.SIGNAL]) == signal:
            factor = p[q + S.POLARITY] * p[q + S.SCALE]
            offset = p[q + S.OFFSET] + p[q + S.BIAS]
            shift = min(p[q + S.DELAY] / period_s, targets.shape[0] - 2.0 - row)
    later, (column, rate_column) = row + int(shift), columns
    part = shift - int(shift)
    value = (1.0 - part) * targets[later, column] + part * targets[later + 1, column]
    rate = (1.0 - part) * targets[later, rate_column] + part * targets[later + 1, rate_column]
    return (value - offset) / factor, rate / factor


@released
def _joint_motion(p: Vector, slot: int, targets: Array, row: int, period_s: float) -> tuple[float, float]:
    """True position and velocity of a joint at a row; NaN where it was not measured."""
    if np.isnan(targets[row, Target.POSITION + slot]):
        return np.nan, np.nan
    return _true_motion(p, TrueSignal.POSITION + slot, targets, row, (Target.POSITION + slot, Target.VELOCITY + slot), period_s)


@released
def begin(x: Vector, p: Vector, targets: Array, period_s: float) -> None:
    """Put joints at rest where the first row says they are, with the scales and offsets that the sensors have in `p`; within the stops."""
    for slot in range(SLOTS):
        position, _ = _joint_motion(p, slot, targets, 0, period_s)
        if not np.isnan(position):
            there = min(max(position, p[J_START + slot * J_STRIDE + J.LOW]), p[J_START + slot * J_STRIDE + J.HIGH])
            move(x, p, slot * D_STRIDE + D.POSITION, there - x[slot * D_STRIDE + D.POSITION], period_s)


@released
def correct(x: Vector, p: Vector, targets: Array, row: int, period_s: float) -> None:
    """Put the measured states where the measurement says they are."""
    for slot in range(SLOTS):
        position, velocity = _joint_motion(p, slot, targets, row, period_s)
        if not np.isnan(position):
            move(x, p, slot * D_STRIDE + D.POSITION, position - x[slot * D_STRIDE + D.POSITION], period_s)
            move(x, p, slot * D_STRIDE + D.VELOCITY, velocity - x[slot * D_STRIDE + D.VELOCITY], period_s)
    if p[C.BENDING_STIFFNESS] > 0.0 and not np.isnan(targets[row, Target.TIP_DEFLECTION]):
        columns = Target.TIP_DEFLECTION + 0, Target.TIP_DEFLECTION_RATE + 0
        value, rate = _true_motion(p, TrueSignal.TIP_DEFLECTION, targets, row, columns, period_s)
        if not np.isnan(value):
            move(x, p, X.SHAPE_1, value - x[X.SHAPE_1], period_s)
            move(x, p, X.SHAPE_1_RATE, rate - x[X.SHAPE_1_RATE], period_s)
