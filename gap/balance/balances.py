"""The balance equations of a rig, formed from what was measured: whichever does not come out even is where the model is wrong.

An equation is formed only where every quantity in it is measured or known from the rig file: the force balance of an axis needs its drive
force (chamber pressures, or the command of an electric drive), a chamber's flow balance its pressure, the bending of the link its tip.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from config.rig import Rig
from gap.balance.weak_form import LEAST_ROWS, Bump, Sum, bump, supports
from gap.data.measured import Array, Measured, bridged
from sim_backend.chambers import compliance
from sim_backend.friction import sliding_level
from sim_backend.layout import J_START, J_STRIDE, C, J, Vector
from sim_backend.link import K11, damping_factor, mass_and_bias
from sim_backend.parameters import Parameters
from sim_backend.table import table_force
from sim_backend.valve import beyond_overlap, land_flow, openings, spool_command

SPANS_S = (0.05, 0.1, 0.2, 0.4)  # supports tried: the shortest in which noise stays small against the terms of the equation
QUIET = 0.05  # share of an equation's terms
KNOWN = 0.05  # relative accuracy of the constants: terms this much smaller than the largest decide nothing
HYDRAULIC, ELECTRIC, IMPOSED = 1.0, 2.0, 3.0


@dataclass(frozen=True, slots=True)
class Balance:
    """One equation over one log. `rows`: middle of every support; `residual`: mean imbalance there; `sd`: what noise and the constants'
    own uncertainty make of it. All in `unit`."""

    equation: str
    where: str
    unit: str
    rows: Array
    residual: Array
    sd: Array

    @property
    def z(self) -> float:
        """Root mean square of the imbalance in standard deviations: about 1 or less for an equation that holds."""
        return float(np.sqrt(np.mean((self.residual / self.sd) ** 2))) if self.residual.size else 0.0


@dataclass(frozen=True, slots=True)
class _Log:
    """What the equations are made of, at every row."""

    rig: Rig
    p: Vector
    slots: Mapping[str, int]
    signals: Mapping[str, Array]
    velocity: Mapping[str, Array]
    commands_V: Mapping[str, Array]
    sigma: Mapping[str, float]
    period_s: float


def balances(log: Measured, rig: Rig, sigma: Mapping[str, float]) -> list[Balance]:
    """Every equation that can be formed on this log, most violated first. `sigma`: noise of each channel."""
    told = _told(log, rig, sigma)
    found = [balance for formed in _formers(told) if (balance := _shortest(told, *formed)) is not None]
    return sorted(found, key=lambda balance: -balance.z)


def obstacles(log: Measured, rig: Rig) -> dict[str, str]:
    """Joint → why its force balance cannot be formed on this log; without the joints for which it can."""
    told = _told(log, rig, {})
    return {joint: why for joint in rig.joints if (why := _obstacle(told, joint))}


def _told(log: Measured, rig: Rig, sigma: Mapping[str, float]) -> _Log:
    parameters = Parameters(rig)
    signals = {name: bridged(channel.values) for name, channel in log.channels.items()}
    velocity = {joint: _rate(signals[f"{joint}.position"], log.period_s) for joint in rig.joints}
    commands = {joint: log.commands_V[:, number] for number, joint in enumerate(rig.joints)}
    return _Log(rig, parameters.values, parameters.slots, signals, velocity, commands, sigma, log.period_s)


def _rate(values: Array, period_s: float) -> Array:
    """A smoothed rate (NaN next to the ends), for the sign of friction and for Coriolis terms; inertia never sees it."""
    half = max(round(0.015 / period_s), 1)
    found = np.full(len(values), np.nan)
    smooth = np.convolve(values, np.ones(2 * half + 1) / (2 * half + 1), mode="valid")
    found[half:-half] = np.gradient(smooth, period_s)
    return found


def _formers(log: _Log) -> Iterator[tuple[str, str, str]]:
    """Equation, place and unit of everything that can be formed."""
    arm = log.p[C.ARM] > 0.0
    for joint, slot in log.slots.items():
        j = J_START + slot * J_STRIDE
        kind, force = log.p[j + J.KIND], "N*m" if slot == 0 else "N"
        pressures = [name for name in ("pressure_a", "pressure_b") if f"{joint}.{name}" in log.signals]
        if not _obstacle(log, joint):
            yield "force balance", joint, force
        if kind == HYDRAULIC:
            for name in pressures:
                yield "chamber flow balance", f"{joint}.{name}", "m^3/s"
    if arm and "tip.deflection" in log.signals and log.p[C.GRAVITY] == 0.0:
        yield "link bending", "link", "N" if log.p[C.BENDING_STIFFNESS] > 0.0 else "m"


def _obstacle(log: _Log, joint: str) -> str:
    """Why the force balance of a joint cannot be formed; empty when it can."""
    j = J_START + log.slots[joint] * J_STRIDE
    kind = log.p[j + J.KIND]
    needed = {HYDRAULIC: ("pressure_a", "pressure_b"), IMPOSED: ("pressure_a",)}.get(kind, ())
    lacking = [f"{joint}.{name}" for name in needed if f"{joint}.{name}" not in log.signals]
    if lacking:
        return f"the drive's force is not known without {' and '.join(lacking)}"
    if log.p[C.ARM] > 0.0 and log.p[C.GRAVITY] != 0.0:
        return "the arm is tilted"
    return "backlash lies between the drive and the load" if log.p[j + J.GAP] != 0.0 else ""


def _shortest(log: _Log, equation: str, where: str, unit: str) -> Balance | None:
    """The equation on the shortest supports on which noise does not drown it."""
    form = {"force balance": _force, "chamber flow balance": _flow, "link bending": _bending}[equation]
    rows_in_all = len(next(iter(log.signals.values())))
    found = None
    for span_s in SPANS_S:
        rows = max(round(span_s / log.period_s), LEAST_ROWS)
        starts: NDArray[np.int64] = np.arange(0, rows_in_all - rows, max(rows // 2, 1), dtype=np.int64)
        if starts.size < 4:
            break
        done, moving = form(log, where, bump(rows, log.period_s), starts)
        good = np.isfinite(done.total) & moving
        if good.sum() < 4:
            continue
        size = float(np.sqrt(np.mean(done.largest[good] ** 2)))
        noise = np.sqrt(done.variance)[good]
        place = where.partition(".")[0]
        found = Balance(equation, place, unit, starts[good] + rows // 2, done.total[good], np.hypot(noise, KNOWN * max(size, 1e-300)))
        if float(np.median(noise)) <= QUIET * size:
            break
    return found


def _force(log: _Log, joint: str, test: Bump, starts: NDArray[np.int64]) -> tuple[Sum, Array]:
    """drive force − friction + table − gravity − d/dt momentum = 0, and where friction is determined at all (the joint slides)."""
    slot, p = log.slots[joint], log.p
    j = J_START + slot * J_STRIDE
    done, name, rows = Sum(len(starts)), f"{joint}.position", test.rows
    _drive(log, joint, j, done, test, starts)
    rubbing, moving = _friction(log, joint, j, starts, rows)
    done.add(-1.0, test.value, rubbing)
    if p[j + J.TABLE_KNOTS] > 0.0 and p[j + J.TABLE_RUBS] == 0.0:
        done.add(1.0, test.value, supports(_tabulated(log, joint, j), starts, rows))
    if p[C.ARM] > 0.0:
        _arm_inertia(log, slot, done, test, starts)
    else:
        mass = p[j + J.MASS] + p[j + J.EXTRA_MASS]
        done.add(-mass, test.acceleration, supports(log.signals[name], starts, rows), log.sigma[name])
        if p[C.GRAVITY] != 0.0 and slot == 1:
            done.total = done.total - p[C.GRAVITY] * mass
    return done, moving


def _drive(log: _Log, joint: str, j: int, done: Sum, test: Bump, starts: NDArray[np.int64]) -> None:
    """The actuator's force: pressures on their areas, or what the command asks of an electric drive."""
    p, rows = log.p, test.rows
    for name, area in (("pressure_a", p[j + J.AREA_A]), ("pressure_b", -p[j + J.AREA_B])):
        channel = f"{joint}.{name}"
        if area != 0.0 and channel in log.signals:
            done.add(area, test.value, supports(log.signals[channel], starts, rows), log.sigma[channel])
    if p[j + J.KIND] != HYDRAULIC:
        sign = -1.0 if p[j + J.KIND] == IMPOSED else 1.0  # a load cell pushes the rod into its chamber
        spool = _spool(log, joint, j)
        left = np.array([beyond_overlap(value, p[j + J.OVERLAP]) for value in spool])
        done.add(sign * p[j + J.FORCE_GAIN], test.held, supports(left, starts, rows))


def _spool(log: _Log, joint: str, j: int) -> Array:
    """Opening asked for at every row: bias, hysteresis and saturation as in the rig file; its lag is not looked at."""
    play, found = 0.0, np.empty(len(log.commands_V[joint]))
    shift = round(log.p[j + J.DELAY] / log.period_s)
    for row, command in enumerate(log.commands_V[joint]):
        found[row], play = spool_command(command, play, log.p, j, 40.0)
    return np.concatenate([np.full(shift, found[0]), found[: len(found) - shift]])


def _friction(log: _Log, joint: str, j: int, starts: NDArray[np.int64], rows: int) -> tuple[Array, Array]:
    """Friction of steady sliding, and the supports in which the joint slides for most of the time (at rest it takes what it must)."""
    p, v = log.p, log.velocity[joint]
    a, b = (log.signals.get(f"{joint}.{name}", np.zeros_like(v)) for name in ("pressure_a", "pressure_b"))
    coulomb = np.full(len(v), p[j + J.COULOMB])
    if p[j + J.TABLE_RUBS] > 0.0 and p[j + J.TABLE_KNOTS] > 0.0:
        coulomb = coulomb + _tabulated(log, joint, j)
    level = np.array([sliding_level(v[k], a[k] - b[k], coulomb[k], p, j) for k in range(len(v))])
    fade = p[j + J.BRISTLE_FADE]
    slope = p[j + J.VISCOUS] + 0.5 * p[j + J.VISCOUS_DIFFERENCE] * np.sign(v)
    force = slope * v + level * np.tanh(2 * v / fade)
    slides = supports((np.abs(v) > fade) | (level == 0.0), starts, rows).mean(axis=1) > 0.8
    return supports(force, starts, rows), np.asarray(slides)


def _tabulated(log: _Log, joint: str, j: int) -> Array:
    """What the joint's table (`unnamed_remainder`) says at every row."""
    v, x, u = log.velocity[joint], log.signals[f"{joint}.position"], log.commands_V[joint]
    late = round(log.p[j + J.DELAY] / log.period_s)
    u = np.concatenate([np.full(late, u[0]), u[: len(u) - late]])
    a, b = (log.signals.get(f"{joint}.{name}", np.zeros_like(v)) for name in ("pressure_a", "pressure_b"))
    return np.array([table_force(v[k], x[k], u[k], a[k] - b[k], log.p, j) for k in range(len(v))])


def _flow(log: _Log, where: str, test: Bump, starts: NDArray[np.int64]) -> tuple[Sum, Array]:
    """flow through the lands − area × velocity − leakage − compliance × d/dt pressure = 0, for chamber A or B."""
    joint, _, chamber = where.partition(".")
    first = chamber == "pressure_a"
    p, j, rows = log.p, J_START + log.slots[joint] * J_STRIDE, test.rows
    pressure, position = log.signals[where], log.signals[f"{joint}.position"]
    done = Sum(len(starts))
    done.add(1.0, test.value, supports(_land_flows(log, joint, j, pressure, first), starts, rows))
    area = p[j + J.AREA_A] if first else -p[j + J.AREA_B]
    done.add(-area, test.rate, supports(position, starts, rows), log.sigma[f"{joint}.position"])
    other = log.signals.get(f"{joint}.pressure_b" if first else f"{joint}.pressure_a")
    if other is not None:
        done.add(-p[j + J.CROSS_LEAKAGE], test.value, supports(pressure - other, starts, rows))
    done.add(-p[j + J.EXTERNAL_LEAKAGE], test.value, supports(pressure, starts, rows))
    middle = starts + rows // 2
    travel = position[middle] - p[j + J.VOLUME_POSITION]
    volume = (p[j + J.VOLUME_A] if first else p[j + J.VOLUME_B]) + area * travel
    soft = np.array([compliance(pressure[k], p[C.BULK_MODULUS], p[j + J.HOSE_COMPLIANCE], p, j) for k in middle])
    done.add(-volume * soft, test.rate, supports(pressure, starts, rows), log.sigma[where])
    return done, np.ones(len(starts), dtype=bool)


def _land_flows(log: _Log, joint: str, j: int, pressure: Array, first: bool) -> Array:
    """Flow into a chamber at every row."""
    p, spool = log.p, _spool(log, joint, j)
    supply = log.signals.get(f"{joint}.supply_pressure", np.full(len(spool), p[C.SUPPLY_PRESSURE]))
    tank = log.signals.get(f"{joint}.return_pressure", np.full(len(spool), p[C.RETURN_PRESSURE]))
    laminar, found = p[j + J.LAMINAR_PRESSURE] ** 2, np.empty(len(spool))
    for k in range(len(spool)):
        opened, closed = openings(spool[k], p, j)
        into, out = (opened, closed) if first else (closed, opened)
        found[k] = into * land_flow(supply[k] - pressure[k], laminar) - out * land_flow(pressure[k] - tank[k], laminar)
    return np.asarray(p[j + J.FLOW_COEFFICIENT] * found)


def _matrix(log: _Log, starts: NDArray[np.int64], rows: int) -> Array:
    """Mass matrix and biases of the arm in the middle of every support (supports × 14, order of mass_and_bias)."""
    first, second = log.velocity["rotary"], log.velocity["prismatic"]
    length = log.signals["prismatic.position"]
    tip = log.signals.get("tip.deflection", np.zeros_like(length))
    tip_d = _rate(tip, log.period_s)
    middle = starts + rows // 2
    return np.array([mass_and_bias(first[k], length[k], second[k], tip[k], 0.0, tip_d[k], 0.0, log.p) for k in middle])


def _arm_inertia(log: _Log, slot: int, done: Sum, test: Bump, starts: NDArray[np.int64]) -> None:
    """Inertia of a joint of the arm, with the mass matrix of each support's middle."""
    m = _matrix(log, starts, test.rows)
    own, cross, bend, bias = (m[:, 0], m[:, 1], m[:, 2], m[:, 10]) if slot == 0 else (m[:, 4], m[:, 1], m[:, 5], m[:, 11])
    names = ("rotary.position", "prismatic.position") if slot == 0 else ("prismatic.position", "rotary.position")
    for factor, name in ((own, names[0]), (cross, names[1]), (bend, "tip.deflection")):
        if name in log.signals:
            done.add(-factor, test.acceleration, supports(log.signals[name], starts, test.rows), log.sigma[name])
    done.total = done.total - bias


def _bending(log: _Log, where: str, test: Bump, starts: NDArray[np.int64]) -> tuple[Sum, Array]:
    """Inertia of the tip + elastic and damping force of the link = 0 in its first shape; of a rigid link: deflection = 0."""
    rows, p, noise = test.rows, log.p, log.sigma["tip.deflection"]
    done, always = Sum(len(starts)), np.ones(len(starts), dtype=bool)
    tip, length = supports(log.signals["tip.deflection"], starts, rows), log.signals["prismatic.position"][starts + rows // 2]
    if p[C.BENDING_STIFFNESS] == 0.0:
        done.add(-1.0, test.value, tip, noise)
        return done, always
    m = _matrix(log, starts, rows)
    for factor, name in ((m[:, 2], "rotary.position"), (m[:, 5], "prismatic.position"), (m[:, 7], "tip.deflection")):
        done.add(-factor, test.acceleration, supports(log.signals[name], starts, rows), log.sigma[name])
    stiffness = p[C.BENDING_STIFFNESS] * K11 / length**3
    done.add(-stiffness, test.value, tip, noise)
    damping = np.array([damping_factor(value, p) for value in length]) * K11
    done.add(-damping, test.rate, tip, noise)
    middle = log.signals["tip.deflection"][starts + rows // 2]
    done.total = done.total - (m[:, 12] - stiffness * middle)  # what is left of the bias without the elastic force: Coriolis, centrifugal
    return done, always
