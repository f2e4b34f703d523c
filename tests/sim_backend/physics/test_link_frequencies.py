"""The kernel's modal matrices against the exact frequency equation of a cantilever with a tip mass, solved by scipy."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from sim_backend.memory.layout import C
from sim_backend.physics.link import damping_factor, fastest_rate, first_frequency, highest_frequency, mass_and_bias
from tests.support.sim_backend.plants import INCH_M, POUND_KG, SimulatedRig, ornl

EI, LINE = 3556.75, 2.545698


def exact_frequencies(length: float, payload: float, tip_inertia: float = 0.0) -> tuple[float, float]:
    """First two roots, Hz, of (P28) of docs/method/plant.md (Euler-Bernoulli beam)."""
    mu, nu = payload / (LINE * length), tip_inertia / (LINE * length**3)

    def equation(b: float) -> float:
        c, s, ch, sh = math.cos(b), math.sin(b), math.cosh(b), math.sinh(b)
        value = 1 + c * ch + mu * b * (c * sh - s * ch) - nu * b**3 * (c * sh + s * ch) + mu * nu * b**4 * (1 - c * ch)
        return value / ch

    betas = _roots(equation, 2)
    return tuple(b * b * math.sqrt(EI / LINE) / (2 * math.pi * length**2) for b in betas)  # type: ignore[return-value]


def _roots(function: Callable[[float], float], count: int) -> list[float]:
    grid = np.arange(0.05, 12, 0.02)
    values = [function(b) for b in grid]
    found = [brentq(function, grid[i], grid[i + 1]) for i in range(len(grid) - 1) if values[i] * values[i + 1] < 0]
    return found[:count]


def kernel_frequencies(p: np.ndarray, length: float) -> tuple[float, float]:
    """Frequencies, Hz, of the kernel's mass matrix and of the stiffness it puts into the bias forces."""
    *_, e11, e12, e22, _, _, _, _ = mass_and_bias(0.0, length, 0.0, 0.0, 0.0, 0.0, 0.0, p)
    stiffness = np.array(
        [[mass_and_bias(0.0, length, 0.0, float(n == 0), float(n == 1), 0.0, 0.0, p)[12 + row] for n in (0, 1)] for row in (0, 1)]
    )
    first, second = np.sqrt(eigh(stiffness, np.array([[e11, e12], [e12, e22]]), eigvals_only=True)) / (2 * np.pi)
    return float(first), float(second)


@pytest.fixture(scope="module")
def parameters() -> np.ndarray:
    return SimulatedRig(ornl()).parameters.values


@pytest.mark.parametrize("damping_ratio", [0.0, 0.01, 0.1, 0.5])
@pytest.mark.parametrize("length_in", [12, 30, 60])
def test_the_fastest_rate_is_the_largest_eigenvalue(parameters: np.ndarray, length_in: int, damping_ratio: float) -> None:
    """Of the damped shapes as a first-order system; a second shape that is damped beyond 1 creeps faster than it would vibrate."""
    p, length = parameters.copy(), length_in * INCH_M
    p[C.LINK_DAMPING] = damping_ratio
    *_, e11, e12, e22, _, _, _, _ = mass_and_bias(0.0, length, 0.0, 0.0, 0.0, 0.0, 0.0, p)
    mass, bending = np.array([[e11, e12], [e12, e22]]), np.diag([3.0, 7.2])
    stiffness, damping = p[C.BENDING_STIFFNESS] / length**3 * bending, damping_factor(length, p) * bending
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]])
    assert fastest_rate(length, p) == pytest.approx(np.abs(np.linalg.eigvals(system)).max(), rel=1e-9)


@pytest.mark.parametrize("length_in", range(12, 61, 6))
@pytest.mark.parametrize("payload_lb", [0, 15, 45, 75])
def test_frequencies_of_fig_8(parameters: np.ndarray, length_in: int, payload_lb: int) -> None:
    """Row 13: f₁ within 0.1 %, f₂ within 3 %, over the whole workspace."""
    p, length = parameters.copy(), length_in * INCH_M
    p[C.PAYLOAD] = payload_lb * POUND_KG
    first, second = kernel_frequencies(p, length)
    exact_first, exact_second = exact_frequencies(length, p[C.PAYLOAD])
    assert first == pytest.approx(exact_first, rel=1e-3)
    assert second == pytest.approx(exact_second, rel=3e-2)
    assert first_frequency(length, p) == pytest.approx(2 * math.pi * first, rel=1e-9)
    assert highest_frequency(length, p) == pytest.approx(2 * math.pi * second, rel=1e-9)


def test_tabulated_values(parameters: np.ndarray) -> None:
    """A few entries of the table itself, so that equation and code cannot be wrong together."""
    table = {(12, 45): 21.528, (30, 45): 5.410, (60, 45): 1.892, (60, 0): 9.006, (60, 75): 1.478, (24, 15): 12.900}
    for (length_in, payload_lb), frequency in table.items():
        p = parameters.copy()
        p[C.PAYLOAD] = payload_lb * POUND_KG
        assert kernel_frequencies(p, length_in * INCH_M)[0] == pytest.approx(frequency, rel=1e-3)


def test_frequency_varies_by_a_magnitude(parameters: np.ndarray) -> None:
    """Row 14: f₁(12 in)/f₁(60 in) = 11.38 with 45 lb."""
    ratio = kernel_frequencies(parameters, 12 * INCH_M)[0] / kernel_frequencies(parameters, 60 * INCH_M)[0]
    assert ratio == pytest.approx(11.38, rel=5e-3)


def test_tip_inertia_lowers_the_second_frequency(parameters: np.ndarray) -> None:
    """0.05 kg m² lowers f₁ by 0.1 % and f₂ by 9 % at 60 in with 45 lb as the exact equation does."""
    p, length = parameters.copy(), 60 * INCH_M
    p[C.PAYLOAD_INERTIA] = 0.05
    first, second = kernel_frequencies(p, length)
    exact_first, exact_second = exact_frequencies(length, p[C.PAYLOAD], 0.05)
    assert first == pytest.approx(exact_first, rel=1e-3)
    assert second == pytest.approx(exact_second, rel=3e-2)
    assert exact_second / exact_frequencies(length, p[C.PAYLOAD])[1] == pytest.approx(0.91, abs=0.01)
