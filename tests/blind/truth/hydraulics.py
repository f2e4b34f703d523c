"""Valve, chambers and supply of the hidden machine ((P1) to (P13) of docs/method/plant.md), as rates of change."""

from __future__ import annotations

import numpy as np
from numba import njit

ATMOSPHERE_PA = 101325.0
AIR_EXPONENT = 1.2
GAS_EXPONENT = 1.4


@njit(cache=True)
def thinner(temperature_C, m):
    """ν(40 °C) / ν(T) by Walther's law."""
    warm = 10.0 ** (10.0 ** (m.viscosity_a - m.viscosity_b * np.log10(temperature_C + 273.15))) - 0.7
    at_40 = 10.0 ** (10.0 ** (m.viscosity_a - m.viscosity_b * np.log10(313.15))) - 0.7
    return at_40 / warm


@njit(cache=True)
def wanted_opening(command_V, play, temperature_C, j):
    """Spool opening asked for, and the new state of the play."""
    if j.command_step > 0.0:
        command_V = j.command_step * np.rint(command_V / j.command_step)
    x = command_V / j.full_scale + j.null + j.null_drift * (temperature_C - 40.0)
    play = min(max(play, x - j.hysteresis), x + j.hysteresis)
    return min(max(play, -j.saturation), j.saturation), play


@njit(cache=True)
def spool_acceleration(x, v, wanted, j):
    rate = 1.0 / j.lag
    a = rate * (rate * (wanted - x) - 2.0 * j.lag_damping * v)
    if (v >= j.slew and a > 0.0) or (v <= -j.slew and a < 0.0):
        return 0.0
    return a


@njit(cache=True)
def root(drop, j):
    return drop / np.sqrt(np.sqrt(drop * drop + j.laminar * j.laminar))


@njit(cache=True)
def land(x, j):
    """Opening of the land that x uncovers: overlap, rounded null, curvature."""
    if j.overlap > 0.0:
        x = np.sign(x) * max(abs(x) - j.overlap, 0.0)
    opened = 0.5 * (x + np.sqrt(x * x + j.rounding * j.rounding))
    return opened * (1.0 + j.curvature * opened)


@njit(cache=True)
def bulk_modulus(gauge_Pa, temperature_C, m, j):
    """β_e, (P8) and (P9) of docs/method/plant.md, Pa."""
    absolute = max(gauge_Pa, m.vapour) + ATMOSPHERE_PA
    warmer = temperature_C - 40.0
    liquid = m.bulk * (1.0 + j.bulk_slope * warmer) + m.bulk_pressure * gauge_Pa
    share = j.air * (ATMOSPHERE_PA / absolute) ** (1.0 / AIR_EXPONENT) if j.air > 0.0 else 0.0
    soft = (1.0 - share) / liquid + share / (AIR_EXPONENT * absolute) + j.hose / (1.0 + j.hose_slope * warmer)
    return 1.0 / soft


@njit(cache=True)
def chambers(x, a_Pa, b_Pa, supply, tank, position, velocity, thin, temperature_C, m, j):
    """dP_A/dt, dP_B/dt, flow from the supply, flow to the tank."""
    up, down = (1.0 + 0.5 * j.asymmetry) * land(x, j), (1.0 - 0.5 * j.asymmetry) * land(-x, j)
    a, b = max(a_Pa, m.vapour), max(b_Pa, m.vapour)
    a_in, a_out = j.flow * up * root(supply - a, j), j.flow * down * root(a - tank, j)
    b_in, b_out = j.flow * down * root(supply - b, j), j.flow * up * root(b - tank, j)
    moved = position - j.volume_at
    leak, outside = j.cross * thin * (a - b), j.external * thin
    va, vb = j.volume_a + j.area_a * moved, j.volume_b - j.area_b * moved
    rise_a = bulk_modulus(a, temperature_C, m, j) / va * (a_in - a_out - j.area_a * velocity - leak - outside * a)
    rise_b = bulk_modulus(b, temperature_C, m, j) / vb * (b_in - b_out + j.area_b * velocity + leak - outside * b)
    return rise_a, rise_b, a_in + b_in, a_out + b_out


@njit(cache=True)
def accumulator(pressure, ratio, pump, taken, m):
    """Rates of gas pressure, gas volume ratio and pump flow; an ideal supply stands still."""
    if m.inverse_gas == 0.0:
        return 0.0, 0.0, 0.0
    demand = min(max((m.supply - pressure) / m.pump_band, 0.0), 1.0)
    oil_in = pump - taken - m.relief_gain * max(pressure - m.relief, 0.0)
    ratio_rate = -m.inverse_gas * oil_in
    return -GAS_EXPONENT * pressure / ratio * ratio_rate, ratio_rate, (m.pump_flow * demand - pump) / m.pump_lag
