"""A single hydraulic axis as a linear system: derivatives of the running plant's own equations at rest, or while it slides.

As for the arm, without Coulomb friction and stiction. The valve of a real axis gives other gains and other damping when it is open, and
to either side where the piston's areas differ, so the axis is linearised about steady sliding too.
"""

from __future__ import annotations

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
from tuning.linear.linear_arm import LinearArm, jacobians

NO_LAG_S = 1e-5
JOINT_STATES = (D.POSITION, D.VELOCITY, D.SPOOL, D.SPOOL_RATE, D.PRESSURE_A, D.PRESSURE_B)
_BALANCED = (D.VELOCITY, D.PRESSURE_A, D.PRESSURE_B)
_NEAR = 1e-6  # of the pressures' and the velocity's rates at full opening


def is_hydraulic_axis(rig: Rig) -> bool:
    """A single axis with a valve in its plant."""
    if rig.arm.kind != "single_axis" or rig.plant is None:
        return False
    return all(getattr(joint, "valve", None) is not None for joint in rig.plant.joints.values())


def linear_axis(
    rig: Rig, position: float, opening: float = 0.0, temperature_C: float | None = None, *, valve_lag: bool = True
) -> LinearArm:
    """Linearise the axis at a position (m or rad) where its spool is open by a share of its stroke, and it slides as fast as that makes it.

    `valve_lag` False: the spool follows at once, for load and oil alone.
    ManeuverError for a rig without a hydraulic axis, and where no steady sliding is found.
    """
    if not is_hydraulic_axis(rig):
        raise ManeuverError("there is no hydraulic axis to linearise", value=rig.arm.kind, limit="single_axis with a valve", where=rig.name)
    plant = SimulatedRig(rig)
    (name,) = plant.joints
    values, slot = plant.parameters.values, plant.parameters.offset(J.KIND, name) // len(J)
    values[[plant.parameters.offset(J.COULOMB, name), plant.parameters.offset(J.STICTION, name)]] = 0.0
    lag = plant.parameters.offset(J.VALVE_TIME, name)
    at_once = values[lag] == 0.0 or not valve_lag
    plant.reset([position], temperature_C)
    values[lag] = NO_LAG_S if at_once else values[lag]
    base, first = plant.state.copy(), slot * D_STRIDE
    base[first + D.VELOCITY] = base[first + D.SPOOL_RATE] = 0.0
    if opening:
        _slide(base, values, slot, opening, rig.name)
    states = [first + int(state) for state in JOINT_STATES]
    a, b = jacobians(base, values, states, slot * W_STRIDE + W.WANTED)
    if at_once:  # the spool is the input
        spool = JOINT_STATES.index(D.SPOOL)
        keep = [i for i in range(len(states)) if i not in (spool, spool + 1)]
        a, b = a[np.ix_(keep, keep)], a[keep, spool]
    row = np.zeros(len(b))
    row[0] = 1.0
    return LinearArm(a, b / values[plant.parameters.offset(J.FULL_SCALE, name)], row, np.zeros(len(b)), 1.0)


def _slide(base: Vector, values: Vector, slot: int, opening: float, where: str) -> None:
    """Set velocity and pressures so that neither changes with the spool held open."""
    first, work, rate = slot * D_STRIDE, np.zeros(WORK), np.zeros(DIFFERENTIAL)
    base[first + D.SPOOL] = opening
    kernel.hold_terms(base, values, work)
    kernel.start_air(base, values, work)
    work[slot * W_STRIDE + W.WANTED] = opening
    index = [first + int(state) for state in _BALANCED]
    scale = np.array([1.0, 1e6, 1e6])

    def imbalance(v: Floats) -> Floats:
        base[index] = v * scale
        rates(base, values, work, 0.0, values[C.STEP], rate)
        return np.asarray(rate[index] / scale)

    size = float(np.abs(imbalance(base[index] / scale)).max())
    found = root(imbalance, base[index] / scale, method="lm")
    left = float(np.abs(imbalance(found.x)).max())
    if left > _NEAR * max(size, 1.0):
        raise ManeuverError("no steady sliding was found", value=opening, limit="a share of the spool's stroke", where=where)
