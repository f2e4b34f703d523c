"""A single hydraulic axis as a linear system: derivatives of the running plant's own equations at rest, or while it slides.

The valve of a real axis gives other gains and other damping when it is open, and to either side where the piston's areas differ, so the
axis is linearised about steady sliding too. Dry friction is left out as for the arm, or taken as its bristles are: at rest they hold the
axis, and while it slides they resist a change of speed by the slope of the friction curve, which falls where the axis slides slowly.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import root

from config.errors import ManeuverError
from config.schema.rig import Rig
from sim_backend.kernel import kernel
from sim_backend.kernel.rates import rates
from sim_backend.memory.layout import D_STRIDE, DIFFERENTIAL, C, D, J, Vector
from sim_backend.memory.work import W_STRIDE, WORK, W
from sim_backend.plant import SimulatedRig
from tuning.arrays import Floats
from tuning.linear.dry_friction import bristles, take_out_dry_friction
from tuning.linear.hydraulic_axis import is_hydraulic_axis
from tuning.linear.linear_arm import LinearArm, jacobians

NO_LAG_S = 1e-5
JOINT_STATES = (D.POSITION, D.VELOCITY, D.SPOOL, D.SPOOL_RATE, D.PRESSURE_A, D.PRESSURE_B)
_BALANCED = (D.VELOCITY, D.PRESSURE_A, D.PRESSURE_B)
_SCALES = {D.VELOCITY: 1.0, D.PRESSURE_A: 1e6, D.PRESSURE_B: 1e6, D.BRISTLE: 1e-4}
_NEAR = 1e-6  # of the pressures' and the velocity's rates at full opening


def linear_axis(
    rig: Rig, position: float, opening: float = 0.0, temperature_C: float | None = None, *, friction: bool = False, valve_lag: bool = True
) -> LinearArm:
    """Linearise the axis at a position (m or rad) where its spool is open by a share of its stroke, and it slides as fast as that makes it.

    `friction` False: without dry friction, whatever makes it; True: with its bristles where anything rubs.
    `valve_lag` False: the spool follows at once, for load and oil alone.
    ManeuverError for a rig without a hydraulic axis, and where no steady sliding is found.
    """
    if not is_hydraulic_axis(rig):
        raise ManeuverError("there is no hydraulic axis to linearise", value=rig.arm.kind, limit="single_axis with a valve", where=rig.name)
    plant = SimulatedRig(rig)
    (name,) = plant.joints
    values, slot = plant.parameters.values, plant.parameters.offset(J.KIND, name) // len(J)
    were = take_out_dry_friction(plant.parameters, name)
    lag = plant.parameters.offset(J.VALVE_TIME, name)
    at_once = values[lag] == 0.0 or not valve_lag
    plant.reset([position], temperature_C)
    values[lag] = NO_LAG_S if at_once else values[lag]
    base, first = plant.state.copy(), slot * D_STRIDE
    base[first + D.VELOCITY] = base[first + D.SPOOL_RATE] = 0.0
    if opening:
        _slide(base, values, slot, opening, rig.name)
    rubs = friction and _rubs(base, values, slot)
    if rubs:
        values[bristles(plant.parameters, name)] = were
        if opening:  # from where it slides without friction, with the bristles bent
            base[first + D.BRISTLE] = _bent(base, values, slot, opening)
            _slide(base, values, slot, opening, rig.name, (*_BALANCED, D.BRISTLE))
    states = [first + int(state) for state in (*JOINT_STATES, *((D.BRISTLE,) if rubs else ()))]
    a, b = jacobians(base, values, states, slot * W_STRIDE + W.WANTED)
    if at_once:
        a, b = _with_the_spool_as_input(a)
    row = np.zeros(len(b))
    row[0] = 1.0
    return LinearArm(a, b / values[plant.parameters.offset(J.FULL_SCALE, name)], row, np.zeros(len(b)), 1.0)


def has_bristles(axis: LinearArm) -> bool:
    """Whether dry friction was taken in: the bristles are a state then, beside pairs of others."""
    return len(axis.b) % 2 == 1


def axis_states(axis: LinearArm, joint: str, unit: str) -> list[str]:
    """Names of its states with their units: with a spool where the valve lags, with bristles where friction is taken in."""
    spool = [] if len(axis.b) < 6 else ["spool", "spool_rate_per_s"]
    bristle = [f"bristle_{unit}"] if has_bristles(axis) else []
    return [f"{joint}_position_{unit}", f"{joint}_velocity_{unit}_per_s", *spool, "pressure_A_Pa", "pressure_B_Pa", *bristle]


def _with_the_spool_as_input(a: Floats) -> tuple[Floats, Floats]:
    """(A, b) of the other states, from A over all of them."""
    spool = JOINT_STATES.index(D.SPOOL)
    keep = [i for i in range(len(a)) if i not in (spool, spool + 1)]
    return a[np.ix_(keep, keep)], a[keep, spool]


def _rubs(base: Vector, values: Vector, slot: int) -> bool:
    """Whether there is dry friction here, asked of the kernel: its bristles follow a motion where anything rubs, and only there."""
    of_motion, _ = jacobians(base, values, [slot * D_STRIDE + D.VELOCITY, slot * D_STRIDE + D.BRISTLE])
    return bool(of_motion[1, 0] != 0.0)


def _bent(base: Vector, values: Vector, slot: int, opening: float) -> float:
    """Deflection at which the bristles of the sliding axis stay as they are; their rate falls in proportion to it."""
    bristle = slot * D_STRIDE + D.BRISTLE
    rates_now = _with_opening(base, values, slot, opening)
    base[bristle] = 0.0
    straight = float(rates_now()[bristle])
    base[bristle] = _SCALES[D.BRISTLE]
    return float(_SCALES[D.BRISTLE] * straight / (straight - rates_now()[bristle]))


def _with_opening(base: Vector, values: Vector, slot: int, opening: float) -> Callable[[], Vector]:
    """The plant's rates with the spool held open, for whatever then stands in `base`."""
    work, rate = np.zeros(WORK), np.zeros(DIFFERENTIAL)
    base[slot * D_STRIDE + D.SPOOL] = opening
    kernel.hold_terms(base, values, work)
    kernel.start_air(base, values, work)
    work[slot * W_STRIDE + W.WANTED] = opening

    def now() -> Vector:
        rates(base, values, work, 0.0, values[C.STEP], rate)
        return rate

    return now


def _slide(base: Vector, values: Vector, slot: int, opening: float, where: str, balanced: tuple[D, ...] = _BALANCED) -> None:
    """Set velocity and pressures, and the bristles, so that none changes with the spool held open."""
    rates_now = _with_opening(base, values, slot, opening)
    index = [slot * D_STRIDE + int(state) for state in balanced]
    scale = np.array([_SCALES[state] for state in balanced])

    def imbalance(v: Floats) -> Floats:
        base[index] = v * scale
        return np.asarray(rates_now()[index] / scale)

    size = float(np.abs(imbalance(base[index] / scale)).max())
    found = root(imbalance, base[index] / scale, method="lm")
    left = float(np.abs(imbalance(found.x)).max())
    if left > _NEAR * max(size, 1.0):
        raise ManeuverError("no steady sliding was found", value=opening, limit="a share of the spool's stroke", where=where)
