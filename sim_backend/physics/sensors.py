"""From the plant's true values to raw counts: lag, delay, scale, offset, noise, steps, range, resolution, drop-outs;
(P35) of docs/method/plant.md."""

from __future__ import annotations

from math import exp, floor, nan, pi, sqrt

import numpy as np

from config.schema.effect import Hook
from sim_backend.memory.compiled import compiled
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
    TrueSignal,
    Vector,
    X,
)
from sim_backend.memory.work import RETURN_AT_VALVE, SHAPE_ACCELERATION, SIGNAL_START, SUPPLY_AT_VALVE, W
from sim_backend.physics.chambers import oil_pressure
from sim_backend.physics.laws import hooked
from sim_backend.physics.link import tip_acceleration
from sim_backend.physics.noise import gaussian_pair, sample_key, uniform

PORT_SHARE = 0.35  # a supply-port thermometer sits between the oil and the valve's metal (docs/method/plant.md, P33)
_read = hooked(Hook.READING)
_DROPOUT_CHANNEL = 1000
_LAGGED, _NOISE, _KEEP, _RING = 0, 1, 2, 3


@compiled
def supply_port(x: Vector) -> float:
    """What a thermometer in a valve's supply port is exposed to, degC."""
    return float(x[H.LINE_END] + PORT_SHARE * (x[H.METAL] - x[H.LINE_END]))


@compiled
def true_signals(x: Vector, p: Vector, w: Vector) -> None:
    """Write the true value of every signal into the work vector. Needs the rates evaluated at this state."""
    for slot in range(SLOTS):
        s, j = slot * D_STRIDE, J_START + slot * J_STRIDE
        on_actuator = p[j + J.GAP] > 0.0 and p[j + J.SENSOR_ON_ACTUATOR] > 0.0
        w[SIGNAL_START + TrueSignal.POSITION + slot] = x[s + D.ACTUATOR_POSITION] if on_actuator else x[s + D.POSITION]
        w[SIGNAL_START + TrueSignal.SECOND_POSITION + slot] = w[SIGNAL_START + TrueSignal.POSITION + slot]
        w[SIGNAL_START + TrueSignal.SUPPLY_PRESSURE + slot] = w[SUPPLY_AT_VALVE + slot]
        w[SIGNAL_START + TrueSignal.RETURN_PRESSURE + slot] = w[RETURN_AT_VALVE + slot]
        w[SIGNAL_START + TrueSignal.SUPPLY_TEMPERATURE + slot] = supply_port(x)
        w[SIGNAL_START + TrueSignal.RETURN_TEMPERATURE + slot] = x[H.RETURN_OIL]
        w[SIGNAL_START + TrueSignal.PRESSURE_A + slot] = oil_pressure(x[s + D.PRESSURE_A], p[C.VAPOUR_PRESSURE])
        w[SIGNAL_START + TrueSignal.PRESSURE_B + slot] = oil_pressure(x[s + D.PRESSURE_B], p[C.VAPOUR_PRESSURE])
    w[SIGNAL_START + TrueSignal.TIP_ACCELERATION] = tip_acceleration(
        x[D_STRIDE + D.POSITION],
        x[D_STRIDE + D.VELOCITY],
        x[D.VELOCITY],
        w[W.ACCELERATION],
        x[X.SHAPE_1],
        w[SHAPE_ACCELERATION],
        p[C.HUB_OFFSET],
    )
    w[SIGNAL_START + TrueSignal.TIP_DEFLECTION] = x[X.SHAPE_1]
    w[SIGNAL_START + TrueSignal.RESERVOIR_TEMPERATURE] = x[H.RESERVOIR]


@compiled
def _draw_noise(x: Vector, p: Vector, keep: bool) -> None:
    """New noise of every sensor at this sample: coloured by its bandwidth with `keep`, else as after a long time."""
    count, key = int(p[C.SENSORS]), sample_key(x[H.SEED], x[H.SAMPLE])
    for first in range(0, count, 2):
        q = S_START + first * S_STRIDE
        if p[q + S.NOISE] == 0.0 and (first + 1 == count or p[q + S_STRIDE + S.NOISE] == 0.0):
            continue
        pair = gaussian_pair(key, first)
        for number in range(first, min(first + 2, count)):
            at = SENSOR_START + number * SENSOR_STRIDE
            share = x[at + _KEEP] if keep else 0.0
            x[at + _NOISE] = share * x[at + _NOISE] + sqrt(1.0 - share * share) * pair[number - first]


@compiled
def start_sensors(x: Vector, p: Vector, w: Vector) -> None:
    """Fill every sensor's lag and delay line with the present true value, as after a long rest."""
    _draw_noise(x, p, False)
    for number in range(int(p[C.SENSORS])):
        at = SENSOR_START + number * SENSOR_STRIDE
        value = w[SIGNAL_START + int(p[S_START + number * S_STRIDE + S.SIGNAL])]
        x[at + _LAGGED] = value
        x[at + _RING : at + _RING + RING] = value


@compiled
def _set_lags(x: Vector, p: Vector, period_s: float) -> None:
    """Share of the old value that each first-order lag keeps over a period; computed when the period changes."""
    x[H.SENSE_PERIOD] = period_s
    for number in range(int(p[C.SENSORS])):
        bandwidth = p[S_START + number * S_STRIDE + S.BANDWIDTH]
        x[SENSOR_START + number * SENSOR_STRIDE + _KEEP] = exp(-2.0 * pi * bandwidth * period_s) if bandwidth > 0.0 else 0.0


@compiled
def follow_sensors(x: Vector, p: Vector, w: Vector, period_s: float) -> None:
    """One period of every sensor's lag, coloured noise and delay line."""
    if x[H.SENSE_PERIOD] != period_s:
        _set_lags(x, p, period_s)
    x[H.SAMPLE] += 1.0
    newest = int(x[H.SAMPLE]) % RING
    _draw_noise(x, p, True)
    for number in range(int(p[C.SENSORS])):
        at = SENSOR_START + number * SENSOR_STRIDE
        value = w[SIGNAL_START + int(p[S_START + number * S_STRIDE + S.SIGNAL])]
        x[at + _LAGGED] = value + x[at + _KEEP] * (x[at + _LAGGED] - value)
        x[at + _RING + newest] = x[at + _LAGGED]


@compiled
def _delayed(x: Vector, at: int, delay_samples: float) -> float:
    """Value of a sensor's delay line, interpolated between samples."""
    delay = min(delay_samples, RING - 2.0)
    whole = floor(delay)
    part = delay - whole
    newest = int(x[H.SAMPLE]) + RING
    value = float(x[at + _RING + (newest - int(whole)) % RING])
    if part == 0.0:
        return value
    return (1.0 - part) * value + part * float(x[at + _RING + (newest - int(whole) - 1) % RING])


@compiled
def raw_counts(x: Vector, p: Vector, period_s: float, out: Vector) -> None:
    """Write the raw count of every sensor; NaN where the sample dropped out. Changes nothing: asking twice gives the same."""
    for number in range(int(p[C.SENSORS])):
        at, q = SENSOR_START + number * SENSOR_STRIDE, S_START + number * S_STRIDE
        if p[q + S.DROPOUT] > 0.0 and uniform(x[H.SEED], x[H.SAMPLE], _DROPOUT_CHANNEL + number) < p[q + S.DROPOUT]:
            out[number] = nan
            continue
        value = _delayed(x, at, p[q + S.DELAY] / period_s)
        reading = p[q + S.POLARITY] * p[q + S.SCALE] * value + p[q + S.OFFSET] + p[q + S.BIAS] + p[q + S.NOISE] * x[at + _NOISE]
        reading = _read(reading, (value,), number, p)
        if p[q + S.QUANTUM] > 0.0:
            reading = p[q + S.QUANTUM] * np.rint(reading / p[q + S.QUANTUM])
        reading = min(max(reading, p[q + S.LOW]), p[q + S.HIGH])
        out[number] = np.rint(reading / p[q + S.RESOLUTION])
