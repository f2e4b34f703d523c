"""The rotary joint with valve, oil and flexible link as a linear system: derivatives of the running plant's own equations.

Nothing is written down twice: the matrices are central differences of `kernel.rates` about rest, with dry friction taken out (a stuck
joint has no frequency response) and the extension held.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import control
import numpy as np

from config.schema.rig import Rig
from sim_backend.kernel import kernel
from sim_backend.kernel.rates import rates
from sim_backend.memory.layout import D_STRIDE, DIFFERENTIAL, SLOTS, C, D, J, Vector, X
from sim_backend.memory.work import WORK, W
from sim_backend.plant import SimulatedRig
from tuning.arrays import Complexes, Floats
from tuning.linear.dry_friction import take_out_dry_friction
from tuning.variants import ROTARY

STATES: tuple[int, ...] = (
    D.POSITION,
    D.VELOCITY,
    D.SPOOL,
    D.SPOOL_RATE,
    D.PRESSURE_A,
    D.PRESSURE_B,
    X.SHAPE_1,
    X.SHAPE_2,
    X.SHAPE_1_RATE,
    X.SHAPE_2_RATE,
)
_STEPS: dict[int, float] = {D.POSITION: 1e-6, D.VELOCITY: 1e-6, D.SPOOL: 1e-6, D.SPOOL_RATE: 1e-4, D.PRESSURE_A: 10.0, D.PRESSURE_B: 10.0,
                            D.BRISTLE: 1e-8}  # fmt: skip
_SHAPE_STEP = 1e-7
_NO_LAG_S = 1e-5


@dataclass(frozen=True, eq=False)
class LinearArm:
    """ẋ = A x + b u; u in V. `position` (rad or m) and `deflection` (m) are output rows; `extension_m` is where it was linearised.
    A single axis has no deflection, and an extension of 1."""

    a: Floats
    b: Floats
    position: Floats
    deflection: Floats
    extension_m: float

    def system(self) -> control.StateSpace:
        """The same for python-control: one input, the outputs position and deflection."""
        return control.ss(self.a, self.b[:, None], np.vstack([self.position, self.deflection]), 0.0)

    def response(self, omega: Floats, output: Floats) -> Complexes:
        """Frequency response from u to an output row at frequencies in rad/s. The margins of a schedule ask for thousands: all
        frequencies at once take a thirteenth of the time that `system()(1j * omega)` takes for one after the other."""
        matrices = 1j * np.asarray(omega)[:, None, None] * np.eye(len(self.b)) - self.a
        right = np.broadcast_to(self.b[:, None], (len(omega), len(self.b), 1))
        return np.asarray(np.linalg.solve(matrices, right)[:, :, 0] @ output)


def linear_arm(
    rig: Rig,
    extension_m: float,
    payload_kg: float | None = None,
    temperature_C: float | None = None,
    *,
    rigid: bool = False,
    stuck: bool = False,
    link_damping: bool = True,
    valve_lag: bool = True,
) -> LinearArm:
    """Linearise the rig's plant at rest. `payload_kg`, `temperature_C`: those of the rig when not given.

    `rigid`: the link does not bend; `stuck`: the joint is held by the bristles of its friction.
    `link_damping`, `valve_lag` False: without them, for closed forms that leave them out.
    """
    plant = SimulatedRig(rig)
    values, offset = plant.parameters.values, plant.parameters.offset
    bristles = take_out_dry_friction(plant.parameters, ROTARY)
    values[[*([C.BENDING_STIFFNESS] if rigid else []), *([] if link_damping else [C.LINK_DAMPING])]] = 0.0
    if payload_kg is not None:
        values[C.PAYLOAD] = payload_kg
    if not valve_lag:
        values[offset(J.VALVE_TIME, ROTARY)] = _NO_LAG_S
    plant.reset([0.0, extension_m], temperature_C)
    plant.state[D_STRIDE + D.VELOCITY] = 0.0
    a, b = jacobians(at_rest(plant.state), values)
    if stuck:
        _hold(a, bristles, values[offset(J.AREA_A, ROTARY)])
    return _with_outputs(a, b / values[offset(J.FULL_SCALE, ROTARY)], extension_m, rigid)


def _with_outputs(a: Floats, b: Floats, extension_m: float, rigid: bool) -> LinearArm:
    """Position and deflection as rows; of a rigid link without the states of its shapes."""
    keep = [i for i, state in enumerate(STATES) if not (rigid and isinstance(state, X))]
    position, deflection = np.zeros(len(keep)), np.zeros(len(keep))
    position[0] = 1.0
    if not rigid:
        deflection[STATES.index(X.SHAPE_1)] = 1.0
    return LinearArm(a[np.ix_(keep, keep)], b[keep], position, deflection, extension_m)


def _hold(a: Floats, bristles: Vector, area: float) -> None:
    """Add what the bristles do, by their stiffness and damping. The pressure of a chamber acts on its area by a torque as they do, which
    tells what a torque moves."""
    pressures = [STATES.index(D.PRESSURE_A), STATES.index(D.PRESSURE_B)]
    by_torque = a[:, pressures[0]] / area
    by_torque[pressures] = 0.0
    a[:, :2] -= np.outer(by_torque, bristles)


def at_rest(state: Vector) -> Vector:
    """The first joint slot at 0 with its spool in the middle."""
    base = state.copy()
    base[: D.PRESSURE_A] = 0.0
    return base


def jacobians(base: Vector, values: Vector, states: Sequence[int] = STATES, wanted: int = W.WANTED) -> tuple[Floats, Floats]:
    """(A, b) over `states` about `base` by central differences; b is per unit of spool opening, at `wanted` of the work."""
    work, rate = np.zeros(WORK), np.zeros((2, DIFFERENTIAL))
    kernel.hold_terms(base, values, work)
    kernel.start_air(base, values, work)
    work[wanted] = 0.0

    def slope(index: int, vector: Vector, step: float) -> Floats:
        middle = vector[index]
        for side in (0, 1):
            vector[index] = middle + (2 * side - 1) * step
            rates(base, values, work, 0.0, values[C.STEP], rate[side])
        vector[index] = middle
        return np.asarray((rate[1] - rate[0])[list(states)] / (2.0 * step))

    columns = [slope(int(state), base, _step(int(state))) for state in states]
    return np.column_stack(columns), slope(int(wanted), work, 1e-6)


def _step(state: int) -> float:
    """Of the central difference: by what a joint's state is, or that of the link's shapes."""
    return _STEPS.get(state % D_STRIDE, _SHAPE_STEP) if state < SLOTS * D_STRIDE else _SHAPE_STEP
