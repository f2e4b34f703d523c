"""The link under prescribed joint motion: ideal joints, only the bending equations, (P25) of docs/method/plant.md, are integrated."""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import ArrayLike, NDArray

from config.errors import PlantError
from config.schema.rig import Rig
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import C, Vector
from sim_backend.physics.link import damping_factor, fastest_rate, mass_and_bias, shape_forces, tip_acceleration

_STEP_FREQUENCY = 0.5  # frequency times step: the fastest shape is resolved, not only stable


def link_response(
    rig: Rig | Vector,
    t_s: ArrayLike,
    theta: ArrayLike,
    theta_d: ArrayLike,
    theta_dd: ArrayLike,
    length_m: ArrayLike,
    length_d: ArrayLike,
    length_dd: ArrayLike,
) -> tuple[Vector, Vector]:
    """Transverse tip acceleration (m/s², as an accelerometer reads it) and tip deflection (m) at times t_s.

    `rig`: a rig with plant.link and link_flexibility, or its parameter vector. All arrays have the length of t_s (equal steps, s); the
    joint motion is linear between samples. The link is at rest and straight at the start. (theta itself matters only with gravity,
    which is not in these equations.)
    """
    p = rig if isinstance(rig, np.ndarray) else Parameters(rig).values
    if p[C.BENDING_STIFFNESS] == 0.0:
        raise PlantError("the link is rigid", next_step="Add link_flexibility to plant.effects.")
    t = np.asarray(t_s, dtype=np.float64)
    motion = np.column_stack([np.asarray(column, dtype=np.float64) for column in (theta_d, theta_dd, length_m, length_d, length_dd)])
    if motion.shape[0] != t.size or np.size(theta) != t.size:
        raise PlantError("all columns of a prescribed motion must have the length of t", value=motion.shape[0], limit=t.size)
    acceleration, deflection = np.empty(t.size), np.empty(t.size)
    step_s = float(t[1] - t[0])
    substeps = max(ceil(step_s * fastest_rate(float(motion[:, 2].min()), p) / _STEP_FREQUENCY), 1)
    _integrate(p, motion, step_s, substeps, acceleration, deflection)
    return acceleration, deflection


@compiled
def _shape_accelerations(
    theta_d: float,
    theta_dd: float,
    length: float,
    length_d: float,
    length_dd: float,
    n1: float,
    n2: float,
    n1_d: float,
    n2_d: float,
    p: Vector,
) -> tuple[float, float]:
    """η̈ from the bending rows of the equations of motion, with the joint accelerations given."""
    _, _, t1, t2, _, l1, l2, e11, e12, e22, _, _, b1, b2 = mass_and_bias(theta_d, length, length_d, n1, n2, n1_d, n2_d, p)
    q1, q2 = shape_forces(length, n1, n1_d, n2_d, b1, b2, damping_factor(length, p), p)
    q1, q2 = q1 - t1 * theta_dd - l1 * length_dd, q2 - t2 * theta_dd - l2 * length_dd
    determinant = e11 * e22 - e12 * e12
    return (e22 * q1 - e12 * q2) / determinant, (e11 * q2 - e12 * q1) / determinant


@compiled
def _rates(
    motion: NDArray[np.float64], i: int, part: float, n: tuple[float, float, float, float], p: Vector
) -> tuple[float, float, float, float]:
    """Rates of (η₁, η₂, η̇₁, η̇₂) at `part` of the way from sample i to the next."""
    j = min(i + 1, motion.shape[0] - 1)
    a, b = 1.0 - part, part
    n1_dd, n2_dd = _shape_accelerations(
        a * motion[i, 0] + b * motion[j, 0],
        a * motion[i, 1] + b * motion[j, 1],
        a * motion[i, 2] + b * motion[j, 2],
        a * motion[i, 3] + b * motion[j, 3],
        a * motion[i, 4] + b * motion[j, 4],
        n[0],
        n[1],
        n[2],
        n[3],
        p,
    )
    return n[2], n[3], n1_dd, n2_dd


@compiled
def _moved(n: tuple[float, float, float, float], d: tuple[float, float, float, float], step: float) -> tuple[float, float, float, float]:
    return n[0] + step * d[0], n[1] + step * d[1], n[2] + step * d[2], n[3] + step * d[3]


@compiled
def _integrate(p: Vector, motion: NDArray[np.float64], step_s: float, substeps: int, acceleration: Vector, deflection: Vector) -> None:
    """Classical fourth-order Runge-Kutta with `substeps` equal steps between samples; writes the two results."""
    n = (0.0, 0.0, 0.0, 0.0)
    h = step_s / substeps
    for i in range(motion.shape[0]):
        theta_d, theta_dd, length, length_d = motion[i, 0], motion[i, 1], motion[i, 2], motion[i, 3]
        n1_dd = _rates(motion, i, 0.0, n, p)[2]
        acceleration[i] = tip_acceleration(length, length_d, theta_d, theta_dd, n[0], n1_dd, p[C.HUB_OFFSET])
        deflection[i] = n[0]
        for k in range(substeps):
            start, middle, end = k / substeps, (k + 0.5) / substeps, (k + 1.0) / substeps
            d1 = _rates(motion, i, start, n, p)
            d2 = _rates(motion, i, middle, _moved(n, d1, 0.5 * h), p)
            d3 = _rates(motion, i, middle, _moved(n, d2, 0.5 * h), p)
            d4 = _rates(motion, i, end, _moved(n, d3, h), p)
            n = _moved(_moved(_moved(_moved(n, d1, h / 6.0), d2, h / 3.0), d3, h / 3.0), d4, h / 6.0)
