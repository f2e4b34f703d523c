"""The kernel's work vector: coefficients that hold for a step or a control period, and the latest outputs. Never part of the state."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import DIFFERENTIAL, SIGNALS, SLOTS, Vector


class W(IntEnum):
    """Coefficients of one slot."""

    LIQUID = 0  # bulk modulus of the liquid at temperature and no pressure
    HOSE = 1
    CROSS = 2
    EXTERNAL = 3
    COULOMB = 4
    VISCOUS = 5
    WANTED = 6  # spool opening the valve is told, constant over a step
    ACCELERATION = 7  # of the load, from the last evaluation
    AIR_A = 8  # share of air at the step's start, and 1 / absolute pressure there
    INVERSE_A = 9
    AIR_B = 10
    INVERSE_B = 11
    VALVE_RATE = 12  # 1 / time constant of the spool
    IMPOSED_ACCELERATION = 13  # of a joint whose motion is imposed
    COMMAND = 14  # V, as it reaches the valve or drive, constant over a step


W_STRIDE = len(W)
SHAPE_ACCELERATION = SLOTS * W_STRIDE  # of η₁
SUPPLY_AT_VALVE = SHAPE_ACCELERATION + 1  # one a slot
RETURN_AT_VALVE = SUPPLY_AT_VALVE + SLOTS
SIGNAL_START = RETURN_AT_VALVE + SLOTS  # true values in the order of layout.Signal
LINK_DAMPING = SIGNAL_START + SIGNALS  # modal damping per modal stiffness number
REFERENCE_VISCOSITY = LINK_DAMPING + 1  # of the oil, mm²/s, where coefficients are stated
WORK = REFERENCE_VISCOSITY + 1


def scratch() -> tuple[Vector, Vector, Vector]:
    """What a Runge-Kutta step needs besides the work vector: the state in between, its rates and their sum."""
    return np.zeros(DIFFERENTIAL), np.zeros(DIFFERENTIAL), np.zeros(DIFFERENTIAL)


@compiled
def copy(source: Vector, target: Vector) -> None:
    """Write the first numbers of `source` into the whole of `target`; they must not overlap (an assignment would allocate for that)."""
    for i in range(target.shape[0]):
        target[i] = source[i]
