"""Energy and momentum of the mechanics, (P24) of docs/method/plant.md, for tests and for looking at a run; not part of the simulation."""

from __future__ import annotations

from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from sim_backend.memory.layout import D_STRIDE, C, D, Vector, X
from sim_backend.physics.link import K11, K22, P1, P2, mass_and_bias


def _mechanics(state: Vector, p: Vector) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mass matrix and rates of (θ, L, η₁, η₂); a rigid link has no rates of η."""
    theta_d, length, length_d = state[D.VELOCITY], state[D_STRIDE + D.POSITION], state[D_STRIDE + D.VELOCITY]
    n1, n2, n1_d, n2_d = state[X.SHAPE_1 : X.SHAPE_2_RATE + 1]
    tt, tl, t1, t2, ll, l1, l2, e11, e12, e22, *_ = mass_and_bias(theta_d, length, length_d, n1, n2, n1_d, n2_d, p)
    matrix = np.array([[tt, tl, t1, t2], [tl, ll, l1, l2], [t1, l1, e11, e12], [t2, l2, e12, e22]])
    return matrix, np.array([theta_d, length_d, n1_d, n2_d])


def mechanical_energy(state: Vector, p: Vector) -> float:
    """Kinetic energy, strain energy of the link and potential energy in a tilted plane, J."""
    matrix, rates = _mechanics(state, p)
    theta, length = state[D.POSITION], state[D_STRIDE + D.POSITION]
    n1, n2 = state[X.SHAPE_1], state[X.SHAPE_2]
    strain = 0.5 * p[C.BENDING_STIFFNESS] / length**3 * (K11 * n1**2 + K22 * n2**2)
    reach = p[C.HUB_OFFSET] + length
    inner = reach - p[C.TUBE_LENGTH]
    line = p[C.MASS_PER_LENGTH]
    along = 0.5 * line * (reach**2 - inner**2) + p[C.PAYLOAD] * reach + p[C.CARRIAGE] * inner
    across = line * length * (P1 * n1 + P2 * n2) + p[C.PAYLOAD] * n1
    height = p[C.GRAVITY] * (along * cos(theta) - across * sin(theta))
    return float(0.5 * rates @ matrix @ rates + strain + height)


def angular_momentum(state: Vector, p: Vector) -> float:
    """Momentum about the hub axis, kg·m²/s; constant without torque about it."""
    matrix, rates = _mechanics(state, p)
    return float(matrix[0] @ rates)
