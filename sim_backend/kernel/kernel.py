"""The compiled plant: one control period a call, or many. Fixed-step Runge-Kutta of fourth order, no allocation, no branch on time.
The step: (P36) of docs/method/plant.md.

Per control period: delay lines, heat, temperature terms, sensors. Per step: delayed command, hysteresis, the spool that follows at
once. Within a step everything else is one system of ordinary differential equations.

The rates at a period's end, which the signals need, are the first of the next period but for the spools, whose commands are new: a
fifth of the work that many periods in one call need not repeat (`rates_stay`).
"""

from __future__ import annotations

from math import ceil, floor

from sim_backend.kernel.rates import rates
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import (
    D_STRIDE,
    DIFFERENTIAL,
    J_START,
    J_STRIDE,
    RING,
    RING_START,
    SLOTS,
    C,
    D,
    H,
    J,
    Kind,
    Vector,
    X,
)
from sim_backend.memory.work import LINK_DAMPING, REFERENCE_VISCOSITY, SIGNAL_START, W_STRIDE, W, copy
from sim_backend.physics.chambers import ATMOSPHERE_PA, air_share, oil_pressure
from sim_backend.physics.link import damping_factor, fastest_rate, frequency_equation
from sim_backend.physics.sensors import follow_sensors, raw_counts, true_signals
from sim_backend.physics.table import COMMAND
from sim_backend.physics.thermal import reference_viscosity, temperature_terms, thermal_step, thinning
from sim_backend.physics.valve import spool_command, spool_rates, stop_spool

_HALF_UP = 1e-9  # a period of exactly n steps must not be cut into n + 1 by rounding
_SURELY = 0.99  # for the rounding of roots that are not taken
_RESOLVED = 2.0  # eigenvalue times step; fourth-order Runge-Kutta is stable up to 2.83 if it vibrates, 2.79 if it creeps


@compiled
def delayed_command(x: Vector, slot: int, begin: float, share: float) -> float:
    """The slot's command averaged over a step that was `share` of a period long and began `begin` periods after the present period did
    (before it: a negative number)."""
    begin = max(begin, 2.0 - RING)
    period = floor(begin)
    ring, head = RING_START + slot * RING, int(x[H.RING_HEAD]) + RING
    command = float(x[ring + (head + int(period)) % RING])
    later = begin + share - period - 1.0  # of the step in the next period's command
    if later <= _HALF_UP or period >= 0.0:
        return command
    return command + later / share * (float(x[ring + (head + int(period) + 1) % RING]) - command)


@compiled
def start_period(x: Vector, command_0: float, command_1: float) -> None:
    """Put the period's commands into the delay lines."""
    x[H.RING_HEAD] = (int(x[H.RING_HEAD]) + 1) % RING
    x[RING_START + int(x[H.RING_HEAD])] = command_0
    x[RING_START + RING + int(x[H.RING_HEAD])] = command_1


@compiled
def start_step(x: Vector, p: Vector, w: Vector, begin: float, share: float, period_s: float) -> None:
    """What is constant over a step: delayed command, hysteresis; and the spool that has no lag. The step begins `begin` periods after the
    period does and is `share` of it long."""
    for slot in range(SLOTS):
        s, j = slot * D_STRIDE, J_START + slot * J_STRIDE
        if int(p[j + J.KIND]) == Kind.UNUSED:
            continue
        command = delayed_command(x, slot, begin - p[j + J.DELAY] / period_s, share)
        wanted, x[H.PLAY + slot] = spool_command(command, x[H.PLAY + slot], p, j, x[H.OIL])
        w[slot * W_STRIDE + W.WANTED], w[slot * W_STRIDE + W.COMMAND] = wanted, command
        if p[j + J.VALVE_TIME] == 0.0:
            reach = p[j + J.SLEW_RATE] * share * period_s
            x[s + D.SPOOL] += min(max(wanted - x[s + D.SPOOL], -reach), reach)


@compiled
def start_air(x: Vector, p: Vector, w: Vector) -> None:
    """Air share of every chamber at the step's start, about which the step expands it."""
    for slot in range(SLOTS):
        s, j, k = slot * D_STRIDE, J_START + slot * J_STRIDE, slot * W_STRIDE
        fraction = p[j + J.AIR_FRACTION]
        if fraction == 0.0:
            w[k + W.AIR_A] = w[k + W.AIR_B] = 0.0
            continue
        a = oil_pressure(x[s + D.PRESSURE_A], p[C.VAPOUR_PRESSURE]) + ATMOSPHERE_PA
        b = oil_pressure(x[s + D.PRESSURE_B], p[C.VAPOUR_PRESSURE]) + ATMOSPHERE_PA
        w[k + W.AIR_A], w[k + W.INVERSE_A] = air_share(a, fraction), 1.0 / a
        w[k + W.AIR_B], w[k + W.INVERSE_B] = air_share(b, fraction), 1.0 / b


@compiled
def rates_stay(p: Vector) -> bool:
    """Whether a new command changes no rates but those of the spools. It changes more where a spool follows at once or a table asks for
    the command; and imposed motion is new every period."""
    for slot in range(SLOTS):
        j = J_START + slot * J_STRIDE
        kind = int(p[j + J.KIND])
        if kind != Kind.UNUSED:
            asks = p[j + J.TABLE_KNOTS] > 0.0 and p[j + J.TABLE_INPUT] == COMMAND
            if kind == Kind.IMPOSED or p[j + J.VALVE_TIME] == 0.0 or asks:
                return False
    return True


@compiled
def renew_spools(x: Vector, p: Vector, w: Vector, d: Vector) -> None:
    """The rates of the spools with the commands of this step; those of everything else stay."""
    for slot in range(SLOTS):
        s, j, k = slot * D_STRIDE, J_START + slot * J_STRIDE, slot * W_STRIDE
        if int(p[j + J.KIND]) != Kind.UNUSED:
            d[s + D.SPOOL], d[s + D.SPOOL_RATE] = spool_rates(
                x[s + D.SPOOL], x[s + D.SPOOL_RATE], w[k + W.WANTED], w[k + W.VALVE_RATE], p, j
            )


@compiled
def runge_kutta_step(x: Vector, p: Vector, w: Vector, y: Vector, d: Vector, total: Vector, step_s: float, known: bool) -> None:
    """One classical fourth-order step of the differential states; y and total are scratch. `known`: d holds the rates at x already, but
    for the spools. The rates stand in a loop: four copies of them, one after the other, are more code than a processor keeps at hand."""
    frozen = x[H.FROZEN]
    if known:
        renew_spools(x, p, w, d)
    else:
        start_air(x, p, w)
        for i in range(DIFFERENTIAL):
            y[i] = x[i]
    for stage in range(4):
        if stage > 0 or not known:
            rates(y, p, w, frozen, step_s, d)
        if stage == 0:
            for i in range(DIFFERENTIAL):
                total[i] = d[i]
                y[i] = x[i] + 0.5 * step_s * d[i]
        elif stage < 3:
            share = 0.5 if stage == 1 else 1.0
            for i in range(DIFFERENTIAL):
                total[i] += 2.0 * d[i]
                y[i] = x[i] + share * step_s * d[i]
        else:
            for i in range(DIFFERENTIAL):
                x[i] += step_s / 6.0 * (total[i] + d[i])
            for s in range(0, SLOTS * D_STRIDE, D_STRIDE):
                stop_spool(x, s + D.SPOOL, s + D.SPOOL_RATE)


@compiled
def resolves(step_s: float, length: float, p: Vector) -> bool:
    """Whether a step is surely short enough for the link, without a root: both frequencies' squares together have room in it, and their sum
    over their product tells that the second shape vibrates, not creeps."""
    determinant, half, product = frequency_equation(length, p)
    vibrates = 4.0 * half * half * p[C.LINK_DAMPING] * p[C.LINK_DAMPING] < _SURELY * determinant * product
    return vibrates and 2.0 * half * step_s * step_s < _SURELY * _RESOLVED * _RESOLVED * determinant


@compiled
def steps_within(period_s: float, x: Vector, p: Vector) -> int:
    """Equal steps that a control period is cut into: none longer than `plant.step`, nor than the link's second shape allows at its
    present length. Its frequency rises with the inverse square of the length; fully retracted it asks for the shortest steps."""
    longest = p[C.STEP]
    if p[C.ARM] > 0.0 and p[C.BENDING_STIFFNESS] > 0.0:
        length = max(p[J_START + J_STRIDE + J.LOW], x[D_STRIDE + D.POSITION])
        if not resolves(longest, length, p):
            longest = min(longest, _RESOLVED / fastest_rate(length, p))
    return int(max(ceil(period_s / longest - _HALF_UP), 1))


@compiled
def hold_terms(x: Vector, p: Vector, w: Vector) -> None:
    """Coefficients that hold for one control period: what temperature does, and the link's damping at its present length."""
    w[REFERENCE_VISCOSITY] = reference_viscosity(p)
    renew_terms(x, p, w)


@compiled
def renew_terms(x: Vector, p: Vector, w: Vector) -> None:
    """hold_terms() at another state, with the parameters it had."""
    thinner = thinning(x[H.OIL], w[REFERENCE_VISCOSITY], p)
    for slot in range(SLOTS):
        if int(p[J_START + slot * J_STRIDE + J.KIND]) != Kind.UNUSED:
            temperature_terms(x[H.OIL], thinner, p, J_START + slot * J_STRIDE, w, slot * W_STRIDE)
    if p[C.ARM] > 0.0:
        w[LINK_DAMPING] = damping_factor(x[D_STRIDE + D.POSITION], p)


@compiled
def evaluate(x: Vector, p: Vector, w: Vector, d: Vector, step_s: float) -> None:
    """Bring the true signals up to date with the state, and d with its rates for a step of this length (as the last start_air() has it)."""
    rates(x, p, w, x[H.FROZEN], step_s, d)
    true_signals(x, p, w)


@compiled
def advance(
    x: Vector,
    p: Vector,
    w: Vector,
    scratch: tuple[Vector, Vector, Vector],
    command_0: float,
    command_1: float,
    period_s: float,
    known: bool = False,
) -> None:
    """One control period with the commands (V, one a slot) held. x: state, p: parameters, w: work vector; x changes in place.

    `known`: w and scratch are as the period before left them, with the same x, p and length, and `rates_stay(p)`. It changes no bit."""
    steps = steps_within(period_s, x, p)
    step_s = period_s / steps
    y, d, total = scratch
    if not known:
        hold_terms(x, p, w)
    start_period(x, command_0, command_1)
    for step in range(steps):
        start_step(x, p, w, step / steps, 1.0 / steps, period_s)
        runge_kutta_step(x, p, w, y, d, total, step_s, known and step == 0)
    x[H.TIME] += period_s
    if p[C.THERMAL] > 0.0:
        taken = x[D.SUPPLY_VOLUME] + x[D_STRIDE + D.SUPPLY_VOLUME]
        thermal_step(x, (taken - x[H.OLD_SUPPLY_VOLUME]) / period_s, x[X.SUPPLY_PRESSURE], p, period_s)
        x[H.OLD_SUPPLY_VOLUME] = taken
    renew_terms(x, p, w)
    start_air(x, p, w)
    evaluate(x, p, w, d, period_s / steps_within(period_s, x, p))
    follow_sensors(x, p, w, period_s)


@compiled
def run(
    x: Vector,
    p: Vector,
    w: Vector,
    scratch: tuple[Vector, Vector, Vector],
    commands: Vector,
    period_s: float,
    states: Vector,
    signals: Vector,
    counts: Vector,
) -> None:
    """Advance by one period for every row of commands (n × 2, V); write differential states, true signals and raw counts.

    Row k of the results is the plant at the start of period k, before command k acts; the log has the same convention.
    """
    stay = rates_stay(p)
    for i in range(commands.shape[0]):
        copy(x, states[i])
        copy(w[SIGNAL_START:], signals[i])
        if counts.shape[0] > 0:
            raw_counts(x, p, period_s, counts[i])
        advance(x, p, w, scratch, commands[i, 0], commands[i, 1], period_s, stay and i > 0)
