"""Derivatives of all differential states: valve, chambers and friction of each slot, then supply and mechanics."""

from __future__ import annotations

from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import D_STRIDE, J_START, J_STRIDE, SLOTS, C, D, J, Kind, Vector, X
from sim_backend.memory.side_by_side import signed_roots
from sim_backend.memory.work import LINK_DAMPING, RETURN_AT_VALVE, SHAPE_ACCELERATION, SUPPLY_AT_VALVE, W_STRIDE, W
from sim_backend.physics.chambers import cross_flow, hoses, oil_pressure, step_smoothing, stiffness
from sim_backend.physics.friction import drive_force, friction, outer_force, stop_force
from sim_backend.physics.gravity import weight
from sim_backend.physics.link import flexible_accelerations, rigid_accelerations
from sim_backend.physics.supply import LINE_RATE, supply_rates, valve_return, valve_supply
from sim_backend.physics.table import table_force
from sim_backend.physics.valve import beyond_overlap, openings, spool_rates

_UNYIELDING = 1e9  # mass (kg) or inertia (kg m²) behind an imposed motion: nothing on the rig slows it
_BALANCE_RATE = 1000.0  # 1/s; a held chamber takes the pressure that balances the load cell this fast


@compiled
def chamber_rates(
    y: Vector,
    d: Vector,
    s: int,
    p: Vector,
    j: int,
    w: Vector,
    k: int,
    slot: int,
    position: float,
    velocity: float,
    step_s: float,
) -> tuple[float, float]:
    """Write the rates of both chambers and hoses of a slot; return the piston's force and the flow taken from the supply."""
    supply = valve_supply(y[X.SUPPLY_PRESSURE], y[s + D.LINE_FLOW], p)
    tank = valve_return(y[s + D.RETURN_FLOW], p)
    w[SUPPLY_AT_VALVE + slot], w[RETURN_AT_VALVE + slot] = supply, tank
    a = oil_pressure(y[s + D.PRESSURE_A], p[C.VAPOUR_PRESSURE])
    b = oil_pressure(y[s + D.PRESSURE_B], p[C.VAPOUR_PRESSURE])
    area_a, area_b = p[j + J.AREA_A], p[j + J.AREA_B]
    travel = position - p[j + J.VOLUME_POSITION]
    volume_a, volume_b = p[j + J.VOLUME_A] + area_a * travel, p[j + J.VOLUME_B] - area_b * travel
    liquid, hose, slope = w[k + W.LIQUID], w[k + W.HOSE], p[C.BULK_PRESSURE_SLOPE]
    rise_a = stiffness(volume_a, a, w[k + W.AIR_A], w[k + W.INVERSE_A], liquid, hoses(hose, a, p, j), slope)
    rise_b = stiffness(volume_b, b, w[k + W.AIR_B], w[k + W.INVERSE_B], liquid, hoses(hose, b, p, j), slope)
    opened, closed = openings(y[s + D.SPOOL], p, j)
    smooth_a = step_smoothing(opened + closed, rise_a, p, j, step_s)
    smooth_b = step_smoothing(opened + closed, rise_b, p, j, step_s)
    flow = p[j + J.FLOW_COEFFICIENT]
    from_supply_a, to_tank_a, from_supply_b, to_tank_b = signed_roots(
        (supply - a, a - tank, supply - b, b - tank), (smooth_a, smooth_a, smooth_b, smooth_b)
    )
    a_in, a_out = flow * opened * from_supply_a, flow * closed * to_tank_a
    b_in, b_out = flow * closed * from_supply_b, flow * opened * to_tank_b
    cross = cross_flow(w[k + W.CROSS], a, b, p, j)
    d[s + D.PRESSURE_A] = rise_a * (a_in - a_out - area_a * velocity - cross - w[k + W.EXTERNAL] * a)
    d[s + D.PRESSURE_B] = rise_b * (b_in - b_out + area_b * velocity + cross - w[k + W.EXTERNAL] * b)
    taken = a_in + b_in
    d[s + D.LINE_FLOW] = (taken - y[s + D.LINE_FLOW]) * LINE_RATE
    d[s + D.RETURN_FLOW] = (a_out + b_out - y[s + D.RETURN_FLOW]) * LINE_RATE
    d[s + D.SUPPLY_VOLUME] = taken
    return area_a * a - area_b * b, taken


@compiled
def imposed_force(y: Vector, d: Vector, slot: int, p: Vector, w: Vector, moves: float, step_s: float) -> tuple[float, float, float]:
    """As joint_force, of a joint moved from outside: the drive is so heavy that the load follows the imposed acceleration. A load
    cell's force (the command) pushes the rod into chamber A, whose pressure answers: A P_A = F + friction + m a."""
    s, j, k = slot * D_STRIDE, J_START + slot * J_STRIDE, slot * W_STRIDE
    acceleration = w[k + W.IMPOSED_ACCELERATION]
    d[s + D.POSITION] = moves * y[s + D.VELOCITY]
    if p[j + J.AREA_A] > 0.0:
        pressure = y[s + D.PRESSURE_A]
        rubbing, d[s + D.BRISTLE] = friction(
            y[s + D.VELOCITY], y[s + D.BRISTLE], pressure, w[k + W.COULOMB], w[k + W.VISCOUS], p, j, step_s
        )
        pushed = p[j + J.FORCE_GAIN] * y[s + D.SPOOL] + (p[j + J.MASS] + p[j + J.EXTRA_MASS]) * acceleration
        d[s + D.PRESSURE_A] = ((pushed + rubbing) / p[j + J.AREA_A] - pressure) * _BALANCE_RATE
    return _UNYIELDING * acceleration, _UNYIELDING, 0.0


@compiled
def joint_force(y: Vector, d: Vector, slot: int, p: Vector, w: Vector, moves: float, step_s: float) -> tuple[float, float, float]:
    """Write the rates of one slot except its load's velocity. Returns the force on the load, the mass the drive train adds to
    the load's own, and the flow taken from the supply."""
    s, j, k = slot * D_STRIDE, J_START + slot * J_STRIDE, slot * W_STRIDE
    if int(p[j + J.KIND]) == Kind.IMPOSED:
        return imposed_force(y, d, slot, p, w, moves, step_s)
    if p[j + J.VALVE_TIME] > 0.0:
        d[s + D.SPOOL], d[s + D.SPOOL_RATE] = spool_rates(y[s + D.SPOOL], y[s + D.SPOOL_RATE], w[k + W.WANTED], w[k + W.VALVE_RATE], p, j)
    backlash = p[j + J.GAP] > 0.0
    load, load_v = y[s + D.POSITION], y[s + D.VELOCITY]
    position, velocity = (y[s + D.ACTUATOR_POSITION], y[s + D.ACTUATOR_VELOCITY]) if backlash else (load, load_v)
    taken, difference = 0.0, 0.0
    if int(p[j + J.KIND]) == Kind.HYDRAULIC:
        force, taken = chamber_rates(y, d, s, p, j, w, k, slot, position, velocity, step_s)
        difference = y[s + D.PRESSURE_A] - y[s + D.PRESSURE_B]
    else:
        force = p[j + J.FORCE_GAIN] * beyond_overlap(y[s + D.SPOOL], p[j + J.OVERLAP])
    outside, coulomb = outer_force(stop_force(load, load_v, p, j), load, load_v, p, j), w[k + W.COULOMB]
    if p[j + J.TABLE_KNOTS] > 0.0:
        unnamed = table_force(load_v, load, w[k + W.COMMAND], difference, p, j)
        if p[j + J.TABLE_RUBS] > 0.0:
            coulomb += unnamed
        else:
            outside += unnamed
    rubbing, d[s + D.BRISTLE] = friction(velocity, y[s + D.BRISTLE], difference, coulomb, w[k + W.VISCOUS], p, j, step_s)
    d[s + D.POSITION] = moves * load_v
    if not backlash:
        return force - rubbing + outside, p[j + J.EXTRA_MASS], taken
    drive = drive_force(position - load, velocity - load_v, p, j)
    d[s + D.ACTUATOR_POSITION] = moves * velocity
    d[s + D.ACTUATOR_VELOCITY] = (force - rubbing - drive) / p[j + J.ACTUATOR_MASS]
    return drive + outside, p[j + J.EXTRA_MASS] - p[j + J.ACTUATOR_MASS], taken


@compiled
def single_axis_acceleration(y: Vector, slot: int, force: float, extra: float, p: Vector) -> float:
    """Acceleration of an independent axis."""
    j = J_START + slot * J_STRIDE
    mass = p[j + J.MASS] + extra
    if p[C.GRAVITY] != 0.0:
        force += weight(slot, y[slot * D_STRIDE + D.POSITION], p)
    return float(force / mass)


@compiled
def rates(y: Vector, p: Vector, w: Vector, frozen: float, step_s: float, d: Vector) -> None:
    """Write dy/dt into d. `frozen` = 1 keeps the positions where they are while everything else moves on."""
    moves = 1.0 - frozen
    force_0 = force_1 = extra_0 = extra_1 = taken_0 = taken_1 = 0.0
    if int(p[J_START + J.KIND]) != Kind.UNUSED:
        force_0, extra_0, taken_0 = joint_force(y, d, 0, p, w, moves, step_s)
    if int(p[J_START + J_STRIDE + J.KIND]) != Kind.UNUSED:
        force_1, extra_1, taken_1 = joint_force(y, d, 1, p, w, moves, step_s)
    supply_rates(y, taken_0 + taken_1, p, d)
    if p[C.ARM] == 0.0:
        for slot in range(SLOTS):
            if int(p[J_START + slot * J_STRIDE + J.KIND]) != Kind.UNUSED:
                force, extra = (force_0, extra_0) if slot == 0 else (force_1, extra_1)
                d[slot * D_STRIDE + D.VELOCITY] = single_axis_acceleration(y, slot, force, extra, p)
    elif p[C.BENDING_STIFFNESS] == 0.0:
        d[D.VELOCITY], d[D_STRIDE + D.VELOCITY] = rigid_accelerations(
            y[D.POSITION], y[D.VELOCITY], y[D_STRIDE + D.POSITION], y[D_STRIDE + D.VELOCITY], force_0, force_1, extra_0, extra_1, p
        )
    else:
        n1_d, n2_d = y[X.SHAPE_1_RATE], y[X.SHAPE_2_RATE]
        d[X.SHAPE_1], d[X.SHAPE_2] = n1_d, n2_d
        d[D.VELOCITY], d[D_STRIDE + D.VELOCITY], d[X.SHAPE_1_RATE], d[X.SHAPE_2_RATE] = flexible_accelerations(
            y[D.POSITION],
            y[D.VELOCITY],
            y[D_STRIDE + D.POSITION],
            y[D_STRIDE + D.VELOCITY],
            y[X.SHAPE_1],
            y[X.SHAPE_2],
            n1_d,
            n2_d,
            force_0,
            force_1,
            extra_0,
            extra_1,
            w[LINK_DAMPING],
            p,
        )
    w[W.ACCELERATION], w[W_STRIDE + W.ACCELERATION] = d[D.VELOCITY], d[D_STRIDE + D.VELOCITY]
    w[SHAPE_ACCELERATION] = d[X.SHAPE_1_RATE]
