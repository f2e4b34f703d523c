"""Gravity on an independent axis in a tilted plane of motion. (An arm's is in the equations of its link.)"""

from __future__ import annotations

from math import sin

from sim_backend.effects.gravity import STANDARD_GRAVITY
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import J_START, J_STRIDE, C, J, Vector


@compiled
def weight(slot: int, position: float, p: Vector) -> float:
    """Force or torque of gravity in the joint's positive direction, with γ = g sin(tilt).

    Turning (slot 0): V = (γ/g) U cos θ, U weight times arm and θ = 0 up the slope, so T = −dV/dθ = (γ/g) U sin θ. Sliding up the slope:
    F = −γ m.
    """
    j = J_START + slot * J_STRIDE
    if slot == 0:
        return float(p[C.GRAVITY] / STANDARD_GRAVITY * p[j + J.UNBALANCE] * sin(position))
    return float(-(p[C.GRAVITY] * (p[j + J.MASS] + p[j + J.EXTRA_MASS])))
