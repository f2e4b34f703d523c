"""The hidden machine in time: classical Runge-Kutta of fourth order at 50 µs, dry friction by elements or by impulse after each step."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numba import njit

from tests.blind.truth.friction import BRISTLE, ELEMENTS, RIGID, SLIP, bristle_force, bristle_rate, element_force, level, slip, viscous
from tests.blind.truth.hydraulics import accumulator, chambers, spool_acceleration, thinner, wanted_opening
from tests.blind.truth.link import MODES, SIZE, TIP, bending_forces, gravity_forces, mass_matrix, solve, velocity_forces

SUBSTEPS = 20  # a cycle of 1 ms
WARM = 40.0


class Y(IntEnum):
    """Places in the state vector."""

    Q = 0  # θ, L, η
    W = 5  # their rates
    BRACKET = 10
    BRACKET_RATE = 11
    ACTUATOR = 12  # position and rate of both actuators, where a joint has play
    SPOOL = 16  # position and rate of both
    PRESSURE = 20  # A and B of both
    LINE = 24  # lagged flow to the tank and from the supply, of both
    GAS = 28
    RATIO = 29
    PUMP = 30
    ELEMENT = 31  # four a joint
    COUNT = 39


Q, W, BRACKET, BRACKET_RATE, ACTUATOR, SPOOL = int(Y.Q), int(Y.W), int(Y.BRACKET), int(Y.BRACKET_RATE), int(Y.ACTUATOR), int(Y.SPOOL)
PRESSURE, LINE, GAS, RATIO, PUMP, ELEMENT, COUNT = (
    int(Y.PRESSURE), int(Y.LINE), int(Y.GAS), int(Y.RATIO), int(Y.PUMP), int(Y.ELEMENT), int(Y.COUNT),
)  # fmt: skip
SIGNALS = 12  # positions, supply and return pressures, tip acceleration and deflection, chamber pressures


@njit(cache=True)
def supply_at(y, joint, t, m):
    """Supply pressure at a joint's valve."""
    flow = y[LINE + 2 * joint + 1]
    ripple = 1.0 + m.pulsation * np.sin(2.0 * np.pi * m.pulsation_Hz * t)
    return y[GAS] * ripple - m.line_resistance * flow * abs(flow)


@njit(cache=True)
def tank_at(y, joint, m):
    flow = y[LINE + 2 * joint]
    return m.tank + m.tank_resistance * flow * abs(flow)


@njit(cache=True)
def drive(twist, rate, j):
    """Spring and damper of a drive train beyond half its play; never pulls."""
    if twist > 0.5 * j.gap:
        return max(j.drive_stiffness * (twist - 0.5 * j.gap) + j.drive_damping * rate, 0.0)
    if twist < -0.5 * j.gap:
        return min(j.drive_stiffness * (twist + 0.5 * j.gap) + j.drive_damping * rate, 0.0)
    return 0.0


@njit(cache=True)
def joint_rates(y, n, t, wanted, temperature_C, thin, m, j, d):
    """Rates of one joint's valve, chambers and actuator. Returns the force on its load."""
    spool = wanted
    if j.lag > 0.0:
        spool = y[SPOOL + 2 * n]
        speed = min(max(y[SPOOL + 2 * n + 1], -j.slew), j.slew)
        d[SPOOL + 2 * n] = speed
        d[SPOOL + 2 * n + 1] = spool_acceleration(spool, y[SPOOL + 2 * n + 1], wanted, j)
    load, load_v = y[Q + n], y[W + n]
    x, v = (y[ACTUATOR + 2 * n], y[ACTUATOR + 2 * n + 1]) if j.gap > 0.0 else (load, load_v)
    a, b = y[PRESSURE + 2 * n], y[PRESSURE + 2 * n + 1]
    supply, tank = supply_at(y, n, t, m), tank_at(y, n, m)
    d[PRESSURE + 2 * n], d[PRESSURE + 2 * n + 1], taken, given = chambers(spool, a, b, supply, tank, x, v, thin, temperature_C, m, j)
    d[LINE + 2 * n] = (given - y[LINE + 2 * n]) * m.line_rate
    d[LINE + 2 * n + 1] = (taken - y[LINE + 2 * n + 1]) * m.line_rate
    force = j.area_a * max(a, m.vapour) - j.area_b * max(b, m.vapour) - viscous(v, thin, j)
    first = ELEMENT + ELEMENTS * n
    if m.friction_form == SLIP:
        force -= element_force(y[first : first + ELEMENTS], v, level(v, a - b, x, temperature_C, j), j)
        for i in range(ELEMENTS):
            d[first + i] = v
    elif m.friction_form == BRISTLE:
        g = level(v, a - b, x, temperature_C, j)
        force -= bristle_force(y[first], v, g, j)
        d[first] = bristle_rate(y[first], v, g, j)
    if j.gap > 0.0:
        through = drive(x - load, v - load_v, j)
        d[ACTUATOR + 2 * n] = v
        d[ACTUATOR + 2 * n + 1] = (force - through) / j.actuator_mass
        force = through
    if load < j.low:
        force += j.stop_stiffness * (j.low - load)
    elif load > j.high:
        force -= j.stop_stiffness * (load - j.high)
    return force, taken


@njit(cache=True)
def mechanics(y, torque, force, m, M, f):
    """Fill M and f = generalised forces − velocity forces, with what plays and added masses change."""
    eta, w = y[Q + 2 : Q + SIZE], y[W : W + SIZE]
    mass_matrix(y[Q + 1], eta, m, M)
    velocity_forces(y[Q + 1], eta, w, m, f[:, 0])
    for i in range(SIZE):
        f[i, 0] = -f[i, 0]
    M[0, 0] += m.rotary.extra_mass - (m.rotary.actuator_mass if m.rotary.gap > 0.0 else 0.0)
    M[1, 1] += m.prismatic.extra_mass - (m.prismatic.actuator_mass if m.prismatic.gap > 0.0 else 0.0)
    f[0, 0] += torque
    f[1, 0] += force
    bending_forces(y[Q + 1], eta, y[W + 2 : W + SIZE], m, f[:, 0])
    if m.gravity != 0.0:
        gravity_forces(y[Q], y[Q + 1], eta, m, f[:, 0])
    if m.bracket_mass > 0.0:
        pull = m.bracket_mass * m.bracket_rate * (m.bracket_rate * y[BRACKET] + 2.0 * m.bracket_damping * y[BRACKET_RATE])
        f[0, 0] += (m.hub_offset + y[Q + 1]) * pull
        for i in range(MODES):
            f[2 + i, 0] += TIP[i] * pull


@njit(cache=True)
def tip_acceleration(y, acceleration, m):
    """What a transverse accelerometer at the tip feels."""
    tip, tip_dd = 0.0, 0.0
    for i in range(MODES):
        tip += TIP[i] * y[Q + 2 + i]
        tip_dd += TIP[i] * acceleration[2 + i]
    return tip_dd + (m.hub_offset + y[Q + 1]) * acceleration[0] + 2.0 * y[W + 1] * y[W] - tip * y[W] ** 2


@njit(cache=True)
def rates(y, t, wanted, temperature_C, thin, m, d):
    """dy/dt; `wanted`: spool openings asked for."""
    d[:] = 0.0
    torque, taken_0 = joint_rates(y, 0, t, wanted[0], temperature_C, thin, m, m.rotary, d)
    force, taken_1 = joint_rates(y, 1, t, wanted[1], temperature_C, thin, m, m.prismatic, d)
    d[GAS], d[RATIO], d[PUMP] = accumulator(y[GAS], y[RATIO], y[PUMP], taken_0 + taken_1, m)
    M, f = np.empty((SIZE, SIZE)), np.zeros((SIZE, 1))
    mechanics(y, torque, force, m, M, f)
    solve(M, f)
    for i in range(SIZE):
        d[Q + i] = y[W + i]
        d[W + i] = f[i, 0]
    if m.bracket_mass > 0.0:
        d[BRACKET] = y[BRACKET_RATE]
        own = m.bracket_rate * (m.bracket_rate * y[BRACKET] + 2.0 * m.bracket_damping * y[BRACKET_RATE])
        d[BRACKET_RATE] = -own - tip_acceleration(y, f[:, 0], m)


@njit(cache=True)
def friction_impulse(y, temperature_C, m, step):
    """Set-valued friction over one step: stop each joint if h g suffices, else brake it by h g; positions get half the change."""
    M, f = np.empty((SIZE, SIZE)), np.zeros((SIZE, 2))
    work = np.zeros((SIZE, 1))
    mechanics(y, 0.0, 0.0, m, M, work)
    f[0, 0] = f[1, 1] = 1.0
    solve(M, f)
    most, used = np.zeros(2), np.zeros(2)
    for n in range(2):
        j = m.rotary if n == 0 else m.prismatic
        v = y[ACTUATOR + 2 * n + 1] if j.gap > 0.0 else y[W + n]
        x = y[ACTUATOR + 2 * n] if j.gap > 0.0 else y[Q + n]
        most[n] = step * level(v, y[PRESSURE + 2 * n] - y[PRESSURE + 2 * n + 1], x, temperature_C, j)
    for _ in range(4):
        for n in range(2):
            j = m.rotary if n == 0 else m.prismatic
            play = j.gap > 0.0
            v = y[ACTUATOR + 2 * n + 1] if play else y[W + n]
            gain = 1.0 / j.actuator_mass if play else f[n, n]
            impulse = min(max(used[n] - v / gain, -most[n]), most[n]) - used[n]
            used[n] += impulse
            if play:
                y[ACTUATOR + 2 * n + 1] += gain * impulse
                y[ACTUATOR + 2 * n] += 0.5 * step * gain * impulse
                continue
            for i in range(SIZE):
                y[W + i] += f[i, n] * impulse
                y[Q + i] += 0.5 * step * f[i, n] * impulse


@njit(cache=True)
def held_command(commands, cycle, share, delay_cycles, joint):
    """The command that acts `share` into a cycle, a delay later than it was given."""
    k = int(np.floor(cycle + share - delay_cycles))
    return commands[max(k, 0), joint]


@njit(cache=True)
def advance(y, play, commands, cycle, t, period, temperature_C, m):
    """One cycle of `period` seconds; row `cycle` of `commands` (V) acts from now. y and play change in place."""
    step = period / SUBSTEPS
    thin = thinner(temperature_C, m)
    wanted = np.zeros(2)
    a, b, c, e, z = np.empty(COUNT), np.empty(COUNT), np.empty(COUNT), np.empty(COUNT), np.empty(COUNT)
    for s in range(SUBSTEPS):
        share = (s + 0.5) / SUBSTEPS
        for n in range(2):
            j = m.rotary if n == 0 else m.prismatic
            command = held_command(commands, cycle, share, j.delay / period, n)
            wanted[n], play[n] = wanted_opening(command, play[n], temperature_C, j)
            if j.lag == 0.0:
                y[SPOOL + 2 * n] += min(max(wanted[n] - y[SPOOL + 2 * n], -j.slew * step), j.slew * step)
                wanted[n] = y[SPOOL + 2 * n]
        rates(y, t, wanted, temperature_C, thin, m, a)
        z[:] = y + 0.5 * step * a
        rates(z, t + 0.5 * step, wanted, temperature_C, thin, m, b)
        z[:] = y + 0.5 * step * b
        rates(z, t + 0.5 * step, wanted, temperature_C, thin, m, c)
        z[:] = y + step * c
        rates(z, t + step, wanted, temperature_C, thin, m, e)
        y += step / 6.0 * (a + 2.0 * b + 2.0 * c + e)
        finish_step(y, temperature_C, m, step)
        t += step


@njit(cache=True)
def finish_step(y, temperature_C, m, step):
    """What is not smooth: spool stops, slipping elements or the friction impulse."""
    for n in range(2):
        j = m.rotary if n == 0 else m.prismatic
        if abs(y[SPOOL + 2 * n]) > 1.0:
            y[SPOOL + 2 * n] = np.sign(y[SPOOL + 2 * n])
            y[SPOOL + 2 * n + 1] = 0.0
        if m.friction_form == SLIP:
            v = y[ACTUATOR + 2 * n + 1] if j.gap > 0.0 else y[W + n]
            x = y[ACTUATOR + 2 * n] if j.gap > 0.0 else y[Q + n]
            first = ELEMENT + ELEMENTS * n
            slip(y[first : first + ELEMENTS], level(v, y[PRESSURE + 2 * n] - y[PRESSURE + 2 * n + 1], x, temperature_C, j), j)
    if m.friction_form == RIGID:
        friction_impulse(y, temperature_C, m, step)


@njit(cache=True)
def signals(y, t, wanted, temperature_C, m, out):
    """Write the true values of the compared signals (SIGNALS)."""
    d = np.empty(COUNT)
    rates(y, t, wanted, temperature_C, thinner(temperature_C, m), m, d)
    for n in range(2):
        out[n] = y[Q + n]
        out[2 + n] = supply_at(y, n, t, m)
        out[4 + n] = tank_at(y, n, m)
        out[8 + 2 * n], out[9 + 2 * n] = max(y[PRESSURE + 2 * n], m.vapour), max(y[PRESSURE + 2 * n + 1], m.vapour)
    out[6] = tip_acceleration(y, d[W : W + SIZE], m)
    out[7] = 0.0
    for i in range(MODES):
        out[7] += TIP[i] * y[Q + 2 + i]


def at_rest(m, position: tuple[float, float]):
    """The state with both joints standing, the supply full and the rotary chambers at half pressure; the piston balances."""
    y = np.zeros(COUNT)
    y[Q : Q + 2] = position
    y[ACTUATOR], y[ACTUATOR + 2] = position
    y[GAS], y[RATIO] = m.supply, 1.0
    y[PRESSURE : PRESSURE + 2] = 0.5 * m.supply
    ratio = m.prismatic.area_b / m.prismatic.area_a
    y[PRESSURE + 2], y[PRESSURE + 3] = 0.4 * m.supply, 0.4 * m.supply / ratio
    return y
