"""The force balance of one joint, (G5) of docs/method/gap.md, over the supports of a log."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from config.schema.effect import Hook
from gap.balance.log_signals import Inertia, LogSignals, mass_matrix, spool
from gap.balance.weak_form import Bump, Sum, supports
from gap.data.measured import Array
from sim_backend.memory.layout import J_START, J_STRIDE, C, J, Kind
from sim_backend.physics.friction import faded, outer_force, sliding_level
from sim_backend.physics.gravity import weight
from sim_backend.physics.laws import LAWS
from sim_backend.physics.table import table_force
from sim_backend.physics.valve import beyond_overlap

_OF_TURNING = {Inertia.TURN: "rotary.position", Inertia.TURN_EXTEND: "prismatic.position", Inertia.TURN_BEND_1: "tip.deflection"}
_OF_EXTENDING = {Inertia.EXTEND: "prismatic.position", Inertia.TURN_EXTEND: "rotary.position", Inertia.EXTEND_BEND_1: "tip.deflection"}


def force_balance(log: LogSignals, joint: str, test: Bump, starts: NDArray[np.int64]) -> tuple[Sum, Array]:
    """drive force − friction + table + own laws of effects + gravity − d/dt momentum = 0, and where friction is determined (the joint
    slides)."""
    slot, p = log.slots[joint], log.p
    j = J_START + slot * J_STRIDE
    done, name, rows = Sum(len(starts)), f"{joint}.position", test.rows
    _drive(log, joint, j, done, test, starts)
    rubbing, moving = _friction(log, joint, j, starts, rows)
    done.add(-1.0, test.value, rubbing)
    if p[j + J.TABLE_KNOTS] > 0.0 and p[j + J.TABLE_RUBS] == 0.0:
        done.add(1.0, test.value, supports(_tabulated(log, joint, j), starts, rows))
    if Hook.FORCE in LAWS:
        done.add(1.0, test.value, supports(_lawful(log, joint, j), starts, rows))
    if p[C.ARM] > 0.0:
        _arm_inertia(log, slot, done, test, starts)
    else:
        mass = p[j + J.MASS] + p[j + J.EXTRA_MASS]
        done.add(-mass, test.acceleration, supports(log.signals[name], starts, rows), log.sigma[name])
        if p[C.GRAVITY] != 0.0:
            pull = np.array([weight(slot, position, p) for position in log.signals[name]])
            done.add(1.0, test.value, supports(pull, starts, rows))
    return done, moving


def _drive(log: LogSignals, joint: str, j: int, done: Sum, test: Bump, starts: NDArray[np.int64]) -> None:
    """The actuator's force: pressures on their areas, or what the command asks of an electric drive."""
    p, rows = log.p, test.rows
    for name, area in (("pressure_a", p[j + J.AREA_A]), ("pressure_b", -p[j + J.AREA_B])):
        channel = f"{joint}.{name}"
        if area != 0.0 and channel in log.signals:
            done.add(area, test.value, supports(log.signals[channel], starts, rows), log.sigma[channel])
    if p[j + J.KIND] != Kind.HYDRAULIC:
        sign = -1.0 if p[j + J.KIND] == Kind.IMPOSED else 1.0  # a load cell pushes the rod into its chamber
        asked = spool(log, joint, j)
        left = np.array([beyond_overlap(value, p[j + J.OVERLAP]) for value in asked])
        done.add(sign * p[j + J.FORCE_GAIN], test.held, supports(left, starts, rows))


def _friction(log: LogSignals, joint: str, j: int, starts: NDArray[np.int64], rows: int) -> tuple[Array, Array]:
    """Friction of steady sliding, and the supports in which the joint slides for most of the time (at rest it takes what it must) and
    is not pressed on a stop."""
    p, v = log.p, log.velocity[joint]
    a, b = (log.signals.get(f"{joint}.{name}", np.zeros_like(v)) for name in ("pressure_a", "pressure_b"))
    coulomb = np.full(len(v), p[j + J.COULOMB])
    if p[j + J.TABLE_RUBS] > 0.0 and p[j + J.TABLE_KNOTS] > 0.0:
        coulomb = coulomb + _tabulated(log, joint, j)
    fade = p[j + J.BRISTLE_FADE]
    level = np.array([sliding_level(v[k], a[k] - b[k], coulomb[k], faded(v[k], fade), p, j) for k in range(len(v))])
    slope = p[j + J.VISCOUS] + 0.5 * p[j + J.VISCOUS_DIFFERENCE] * np.sign(v)
    force = slope * v + level * np.tanh(2 * v / fade)
    slides = supports((np.abs(v) > fade) | (level == 0.0), starts, rows).mean(axis=1) > 0.8
    free = ~supports(log.pressed[joint].astype(np.float64), starts, rows).any(axis=1)
    return supports(force, starts, rows), np.asarray(slides & free)


def _tabulated(log: LogSignals, joint: str, j: int) -> Array:
    """What the joint's table (`unnamed_remainder`) says at every row."""
    v, x, u = log.velocity[joint], log.signals[f"{joint}.position"], log.commands_V[joint]
    late = round(log.p[j + J.DELAY] / log.period_s)
    u = np.concatenate([np.full(late, u[0]), u[: len(u) - late]])
    a, b = (log.signals.get(f"{joint}.{name}", np.zeros_like(v)) for name in ("pressure_a", "pressure_b"))
    return np.array([table_force(v[k], x[k], u[k], a[k] - b[k], log.p, j) for k in range(len(v))])


def _lawful(log: LogSignals, joint: str, j: int) -> Array:
    """The force of the effects' own laws at every row."""
    v, x = log.velocity[joint], log.signals[f"{joint}.position"]
    return np.array([outer_force(0.0, x[k], v[k], log.p, j) for k in range(len(v))])


def _arm_inertia(log: LogSignals, slot: int, done: Sum, test: Bump, starts: NDArray[np.int64]) -> None:
    """Inertia of a joint of the arm, with the mass matrix of each support's middle."""
    m = mass_matrix(log, starts, test.rows)
    columns, bias = (_OF_TURNING, Inertia.TURN_BIAS) if slot == 0 else (_OF_EXTENDING, Inertia.EXTEND_BIAS)
    for column, name in columns.items():
        if name in log.signals:
            done.add(-m[:, column], test.acceleration, supports(log.signals[name], starts, test.rows), log.sigma[name])
    done.total = done.total - m[:, bias]
