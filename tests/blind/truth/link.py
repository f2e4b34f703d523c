"""Rotation, extension and three bending shapes of the sliding link, by Lagrange from one mass matrix.

T = ½ wᵀM(q)w with w = (θ̇, L̇, η̇); the velocity forces are Ṁw − ½ ∂(wᵀMw)/∂q, formed from ∂M/∂q. Shapes over ξ = x/L: the two of
(P22) of docs/method/plant.md and ψ₃ = ξ²(1−ξ)(1−2ξ), which the finder's model does not have. u(x,t) and the frame: (P22), (P23).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.polynomial import Polynomial as Poly
from numpy.typing import NDArray

Array = NDArray[np.float64]

SHAPES = (Poly([0, 0, 1.5, -0.5]), Poly([0, 0, 3, -5, 2]), Poly([0, 0, 1, -3, 2]))
MODES = len(SHAPES)
SIZE = 2 + MODES
_XI, _REST = Poly([0, 1]), Poly([1, -1])


def _integral(p: Poly) -> float:
    whole = p.integ()
    return float(whole(1.0) - whole(0.0))


def _table(left: list[Poly], right: list[Poly]) -> Array:
    return np.array([[_integral(a * b) for b in right] for a in left])


_SLOPES = [p.deriv() for p in SHAPES]
_CURVES = [p.deriv(2) for p in SHAPES]
MASS = _table(list(SHAPES), list(SHAPES))
BEND = _table(_CURVES, _CURVES)
CARRY = _table(list(SHAPES), [_REST * s for s in _SLOPES])
STRETCH = _table([_REST * s for s in _SLOPES], [_REST * s for s in _SLOPES])
FIRST = np.array([_integral(p) for p in SHAPES])
MOMENT = np.array([_integral(_XI * p) for p in SHAPES])
CALM = np.array([1.0, 1.0, 0.3])  # the third shape is damped less than its frequency asks, for the step's sake
TIP = np.array([float(p(1.0)) for p in SHAPES])


@njit(cache=True)
def mass_matrix(length, eta, m, M):
    """Write M(q), 5 × 5; m: Machine."""
    line, reach = m.mass_per_length * length, m.hub_offset + length
    inner = reach - m.tube_length
    quad, turn, stretch = 0.0, 0.0, 0.0
    for i in range(MODES):
        row, str_row, car = 0.0, 0.0, 0.0
        for j in range(MODES):
            e = line * MASS[i, j] + m.payload * TIP[i] * TIP[j]
            M[2 + i, 2 + j] = e
            row += e * eta[j]
            str_row += STRETCH[i, j] * eta[j]
            car += CARRY[i, j] * eta[j]
        quad += eta[i] * row
        stretch += eta[i] * str_row
        turn += (m.mass_per_length * (m.hub_offset * FIRST[i] + 2.0 * length * (MOMENT[i] - FIRST[i])) - m.payload * TIP[i]) * eta[i]
        M[0, 2 + i] = M[2 + i, 0] = line * (m.hub_offset * FIRST[i] + length * MOMENT[i]) + m.payload * reach * TIP[i]
        M[1, 2 + i] = M[2 + i, 1] = m.mass_per_length * car
    M[0, 0] = m.hub_inertia + m.mass_per_length / 3.0 * (reach**3 - inner**3) + m.payload * reach**2 + quad
    M[0, 1] = M[1, 0] = turn
    M[1, 1] = m.mass_per_length * m.tube_length + m.carriage + m.payload + m.mass_per_length / length * stretch


@njit(cache=True)
def velocity_forces(length, eta, w, m, b):
    """Write Ṁw − ½ ∂(wᵀMw)/∂q."""
    rho, a, tip = m.mass_per_length, m.hub_offset, m.payload
    reach = a + length
    inner = reach - m.tube_length
    td, ld = w[0], w[1]
    m_eta, d_eta = np.zeros(MODES), np.zeros(MODES)
    m_rate, c_rate, ct_rate = np.zeros(MODES), np.zeros(MODES), np.zeros(MODES)
    for i in range(MODES):
        for j in range(MODES):
            m_eta[i] += MASS[i, j] * eta[j]
            d_eta[i] += STRETCH[i, j] * eta[j]
            m_rate[i] += MASS[i, j] * w[2 + j]
            c_rate[i] += CARRY[i, j] * w[2 + j]
            ct_rate[i] += CARRY[j, i] * w[2 + j]
    tt_l = rho * (reach**2 - inner**2) + 2.0 * tip * reach
    tl_l, ll_l, kinetic = 0.0, 0.0, 0.0
    tt_dot, tl_dot, ll_dot, sweep = 0.0, 0.0, 0.0, 0.0
    for i in range(MODES):
        tt_l += rho * eta[i] * m_eta[i]
        tl_l += 2.0 * rho * (MOMENT[i] - FIRST[i]) * eta[i]
        ll_l -= rho / length**2 * eta[i] * d_eta[i]
        kinetic += w[2 + i] * m_rate[i]
    w_tip, w_rate = 0.0, 0.0
    for i in range(MODES):
        w_tip += TIP[i] * eta[i]
        w_rate += TIP[i] * w[2 + i]
    tt_dot = tt_l * ld
    tl_dot = tl_l * ld
    ll_dot = ll_l * ld
    for i in range(MODES):
        tt_dot += 2.0 * (rho * length * m_eta[i] + tip * TIP[i] * w_tip) * w[2 + i]
        tl_dot += (rho * (a * FIRST[i] + 2.0 * length * (MOMENT[i] - FIRST[i])) - tip * TIP[i]) * w[2 + i]
        ll_dot += 2.0 * rho / length * d_eta[i] * w[2 + i]
        sweep += (rho * (a * FIRST[i] + 2.0 * length * MOMENT[i]) + tip * TIP[i]) * w[2 + i]
    carried = 0.0
    for i in range(MODES):
        carried += c_rate[i] * w[2 + i]
    b[0] = tt_dot * td + tl_dot * ld + ld * sweep
    energy_l = tt_l * td**2 + 2.0 * tl_l * td * ld + 2.0 * td * sweep + ll_l * ld**2 + rho * kinetic
    b[1] = tl_dot * td + ll_dot * ld + rho * carried - 0.5 * energy_l
    for i in range(MODES):
        turn = rho * (a * FIRST[i] + 2.0 * length * (MOMENT[i] - FIRST[i])) - tip * TIP[i]
        rate = ld * (rho * (a * FIRST[i] + 2.0 * length * MOMENT[i]) + tip * TIP[i]) * td + rho * c_rate[i] * ld + ld * rho * m_rate[i]
        slope = (rho * length * m_eta[i] + tip * TIP[i] * w_tip) * td**2 + turn * td * ld + rho / length * d_eta[i] * ld**2
        b[2 + i] = rate - slope - rho * ld * ct_rate[i]


@njit(cache=True)
def bending_forces(length, eta, rate, m, f):
    """Add −∂V/∂q of the bending energy and the structural damping to f (5)."""
    stiff = m.bending / length**3
    first = np.sqrt(3.0 * stiff / (m.payload + 33.0 / 140.0 * m.mass_per_length * length))
    damp = 2.0 * m.damping / first * stiff
    total = 0.0
    for i in range(MODES):
        row, drag = 0.0, 0.0
        for j in range(MODES):
            row += BEND[i, j] * eta[j]
            drag += CALM[i] * CALM[j] * BEND[i, j] * rate[j]
        f[2 + i] -= stiff * row + damp * drag
        total += eta[i] * row
    f[1] += 1.5 * stiff / length * total


@njit(cache=True)
def gravity_forces(theta, length, eta, m, f):
    """Add −∂V/∂q of gravity along the slope; a point at x along the arm and u across it is (a+x) cos θ − u sin θ up the slope."""
    reach = m.hub_offset + length
    inner = reach - m.tube_length
    moment = 0.5 * m.mass_per_length * (reach**2 - inner**2) + m.payload * reach + m.carriage * inner
    across, area = 0.0, 0.0
    for i in range(MODES):
        pull = m.mass_per_length * length * FIRST[i] + m.payload * TIP[i]
        across += pull * eta[i]
        area += m.mass_per_length * FIRST[i] * eta[i]
        f[2 + i] += m.gravity * pull * np.sin(theta)
    f[0] += m.gravity * (moment * np.sin(theta) + across * np.cos(theta))
    weight = m.mass_per_length * m.tube_length + m.payload + m.carriage
    f[1] -= m.gravity * (weight * np.cos(theta) - area * np.sin(theta))


@njit(cache=True)
def solve(M, f):
    """f ← M⁻¹ f for a symmetric positive matrix and one or more right sides (n × k); M is destroyed."""
    n = M.shape[0]
    for i in range(n):
        for r in range(i + 1, n):
            share = M[r, i] / M[i, i]
            for c in range(i, n):
                M[r, c] -= share * M[i, c]
            for c in range(f.shape[1]):
                f[r, c] -= share * f[i, c]
    for i in range(n - 1, -1, -1):
        for c in range(f.shape[1]):
            total = f[i, c]
            for r in range(i + 1, n):
                total -= M[i, r] * f[r, c]
            f[i, c] = total / M[i, i]
