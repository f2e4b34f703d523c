"""The hidden machine's link against conservation laws and the exact frequency equation; none of it knows the finder's kernel."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq

from config.loading.load import load_rig
from tests.blind.truth.link import MODES, SIZE, TIP, bending_forces, gravity_forces, mass_matrix, solve, velocity_forces
from tests.blind.truth.nominal import machine, nominal

pytestmark = pytest.mark.slow  # numba compiles the whole machine
NUMBERS = nominal(load_rig("ornl_testbed").rig)
INCH, POUND = 0.0254, 0.45359237


def free_motion(t: float, y: np.ndarray, m: object) -> np.ndarray:
    M, f = np.empty((SIZE, SIZE)), np.zeros((SIZE, 1))
    mass_matrix(y[1], y[2:5], m, M)
    velocity_forces(y[1], y[2:5], y[5:10], m, f[:, 0])
    f *= -1
    bending_forces(y[1], y[2:5], y[7:10], m, f[:, 0])
    gravity_forces(y[0], y[1], y[2:5], m, f[:, 0])
    solve(M, f)
    return np.concatenate([y[5:10], f[:, 0]])


def energy(y: np.ndarray, m: object) -> float:
    """Kinetic and bending energy, and height up the slope by summing the tube in thin slices."""
    M, f = np.empty((SIZE, SIZE)), np.zeros(SIZE)
    mass_matrix(y[1], y[2:5], m, M)
    bending_forces(y[1], y[2:5], np.zeros(MODES), m, f)
    potential = -0.5 * f[2:] @ y[2:5]
    xi = (np.arange(4000) + 0.5) / 4000
    shapes = np.stack([(3 * xi**2 - xi**3) / 2, 3 * xi**2 - 5 * xi**3 + 2 * xi**4, xi**2 * (1 - xi) * (1 - 2 * xi)])
    across = shapes.T @ y[2:5]
    inside = (xi - 1) * (m.tube_length - y[1])
    height = m.mass_per_length * y[1] * np.mean(xi * y[1] * np.cos(y[0]) - across * np.sin(y[0]))
    height += m.mass_per_length * (m.tube_length - y[1]) * np.mean(inside) * np.cos(y[0])
    height += m.carriage * (y[1] - m.tube_length) * np.cos(y[0]) + m.payload * (y[1] * np.cos(y[0]) - TIP @ y[2:5] * np.sin(y[0]))
    return float(0.5 * y[5:] @ M @ y[5:] + potential + m.gravity * height)


@pytest.mark.parametrize("gravity", [0.0, 2.0])
def test_free_motion_keeps_energy(gravity: float) -> None:
    m = machine(NUMBERS | {"damping": 0.0, "gravity": gravity})
    start = np.array([0.3, 0.6, 0.01, 0.002, 0.001, 0.8, 0.7, 0.1, 0.0, 0.05])
    run = solve_ivp(free_motion, (0, 1.0), start, method="DOP853", rtol=1e-11, atol=1e-13, args=(m,))
    before, after = energy(start, m), energy(run.y[:, -1], m)
    assert run.y[1].max() > 0.7
    assert after == pytest.approx(before, abs=1e-6 * max(abs(before), 20))


def test_free_motion_keeps_angular_momentum() -> None:
    m = machine(NUMBERS | {"damping": 0.0})
    start = np.array([0.3, 0.6, 0.01, 0.002, 0.001, 0.8, 0.7, 0.1, 0.0, 0.05])
    run = solve_ivp(free_motion, (0, 1.0), start, method="DOP853", rtol=1e-11, atol=1e-13, args=(m,))
    momenta = []
    for y in (start, run.y[:, -1]):
        M = np.empty((SIZE, SIZE))
        mass_matrix(y[1], y[2:5], m, M)
        momenta.append(M[0] @ y[5:])
    assert momenta[1] == pytest.approx(momenta[0], rel=1e-9)


def exact_frequencies(length: float, payload: float, m: object) -> list[float]:
    """Clamped beam with a tip mass: 1 + cos b cosh b + μ b (cos b sinh b − sin b cosh b) = 0."""
    mu = payload / (m.mass_per_length * length)

    def det(b: float) -> float:
        return float(1 / np.cosh(b) + np.cos(b) + mu * b * (np.cos(b) * np.tanh(b) - np.sin(b)))

    grid = np.linspace(0.05, 12, 4000)
    values = [det(b) for b in grid]
    roots = [brentq(det, a, b) for a, b, u, v in zip(grid, grid[1:], values, values[1:], strict=False) if u * v < 0]
    return [b * b * np.sqrt(m.bending / m.mass_per_length) / (2 * np.pi * length**2) for b in roots[:3]]


@pytest.mark.parametrize(("inches", "pounds"), [(12, 45), (36, 45), (60, 45), (60, 75), (36, 15)])
def test_clamped_frequencies(inches: float, pounds: float) -> None:
    length, payload = inches * INCH, pounds * POUND
    m = machine(NUMBERS | {"payload": payload})
    M, K = np.empty((SIZE, SIZE)), np.zeros((MODES, MODES))
    mass_matrix(length, np.zeros(MODES), m, M)
    for k in range(MODES):
        f = np.zeros(SIZE)
        bending_forces(length, np.eye(MODES)[k], np.zeros(MODES), m, f)
        K[:, k] = -f[2:]
    found = np.sqrt(eigh(K, M[2:, 2:], eigvals_only=True)) / (2 * np.pi)
    exact = exact_frequencies(length, payload, m)
    assert found[0] == pytest.approx(exact[0], rel=1e-4)
    assert found[1] == pytest.approx(exact[1], rel=2.5e-3)
    assert exact[2] <= found[2] < 1.6 * exact[2]  # a bound from above, and coarse: there are no more shapes
