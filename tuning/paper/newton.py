"""Newton's law on the material points of the arm, without a Lagrangian: judge of the equations of motion the plant integrates.

Positions are differentiated numerically in extended precision, forces are summed by Gauss quadrature (exact for these polynomials).
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from sim_backend.memory.layout import C, Vector
from sim_backend.physics.link import K11, K22, mass_and_bias

Long = NDArray[np.longdouble]
STEP = np.longdouble(2e-3)
_FIRST = ((-4, 1 / 280), (-3, -4 / 105), (-2, 1 / 5), (-1, -4 / 5), (1, 4 / 5), (2, -1 / 5), (3, 4 / 105), (4, -1 / 280))
_SECOND = ((-4, -1 / 560), (-3, 8 / 315), (-2, -1 / 5), (-1, 8 / 5), (0, -205 / 72), (1, 8 / 5), (2, -1 / 5), (3, 8 / 315), (4, -1 / 560))


def largest_disagreement(p: Vector, states: int = 20, seed: int = 3) -> float:
    """Largest difference of the generalised forces of (θ, L, η₁, η₂), relative to the largest of them, over random motions."""
    random = np.random.default_rng(seed)
    worst = 0.0
    for _ in range(states):
        q = np.array([random.uniform(-1, 1), random.uniform(0.4, 1.5), *random.uniform(-0.05, 0.05, 2)])
        qd, qdd = random.uniform(-1, 1, 4), random.uniform(-3, 3, 4)
        newton, lagrange = newton_forces(q, qd, qdd, p), lagrange_forces(q, qd, qdd, p)
        worst = max(worst, float(np.abs(newton - lagrange).max() / np.abs(lagrange).max()))
    return worst


def lagrange_forces(q: Vector, qd: Vector, qdd: Vector, p: Vector) -> Vector:
    """M q̈ + bias of the plant's own mass matrix and bias."""
    tt, tl, t1, t2, ll, l1, l2, e11, e12, e22, *bias = mass_and_bias(qd[0], q[1], qd[1], q[2], q[3], qd[2], qd[3], p)
    matrix = np.array([[tt, tl, t1, t2], [tl, ll, l1, l2], [t1, l1, e11, e12], [t2, l2, e12, e22]])
    return np.asarray(matrix @ qdd + np.array(bias))


def newton_forces(q: Vector, qd: Vector, qdd: Vector, p: Vector) -> Vector:
    """Σ m r̈ · ∂r/∂qᵢ over hub, carriage, tube and payload, plus the derivatives of the strain energy."""
    length, tube = q[1], p[C.TUBE_LENGTH]
    forces = np.array([p[C.HUB_INERTIA] * qdd[0], p[C.CARRIAGE] * qdd[1], 0.0, 0.0])
    nodes, weights = leggauss(12)
    for start, end in ((length - tube, 0.0), (0.0, length)):
        for node, weight in zip(nodes, weights, strict=True):
            x = 0.5 * (start + end) + 0.5 * (end - start) * node
            mass = p[C.MASS_PER_LENGTH] * 0.5 * (end - start) * weight
            forces += mass * _projected(q, qd, qdd, x, end > 0.0, p[C.HUB_OFFSET])
    forces += p[C.PAYLOAD] * _projected(q, qd, qdd, length, True, p[C.HUB_OFFSET])
    strain = p[C.BENDING_STIFFNESS] / length**3
    bent = K11 * q[2] ** 2 + K22 * q[3] ** 2
    return np.asarray(forces + strain * np.array([0.0, -1.5 * bent / length, K11 * q[2], K22 * q[3]]))


def _projected(q: Vector, qd: Vector, qdd: Vector, x: float, outside: bool, offset: float) -> Vector:
    """r̈ · ∂r/∂qᵢ of the material point now at x, which keeps its distance to the tip while the tube slides."""
    wide, rate, acceleration = (np.asarray(v, dtype=np.longdouble) for v in (q, qd, qdd))

    def position(c: Long) -> np.clongdouble:
        here = np.longdouble(x) + c[1] - wide[1]
        s = here / c[1]
        bend = ((3 * s**2 - s**3) / 2 * c[2] + (3 * s**2 - 5 * s**3 + 2 * s**4) * c[3]) if outside else np.longdouble(0)
        return np.clongdouble((offset + here + 1j * bend) * np.exp(1j * np.clongdouble(c[0])))

    second = sum(w * position(wide + k * STEP * rate + 0.5 * (k * STEP) ** 2 * acceleration) for k, w in _coefficients(_SECOND)) / STEP**2
    units = np.eye(4, dtype=np.longdouble)
    columns = [sum(w * position(wide + k * STEP * unit) for k, w in _coefficients(_FIRST)) / STEP for unit in units]
    return np.array([float((second * np.conj(column)).real) for column in columns])


def _coefficients(table: tuple[tuple[int, float], ...]) -> list[tuple[int, np.longdouble]]:
    return [(k, np.longdouble(w)) for k, w in table]
