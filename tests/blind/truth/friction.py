"""Dry friction of the hidden machine in three forms. Two are not the finder's; the third is, as a control.

SLIP: Maxwell-slip (Iwan): parallel springs that slip at their share of the Stribeck level g(v); presliding remembers its turns.
RIGID: set-valued, no presliding at all; an impulse within ±h g that stops the joint if it can (Moreau's time stepping).
BRISTLE: LuGre as (P14) to (P16) of docs/method/plant.md.
"""

from __future__ import annotations

import numpy as np
from numba import njit

SLIP, RIGID, BRISTLE = 0.0, 1.0, 2.0
ELEMENTS = 4
FASTEST = 2e4  # 1/s; one over the integrator's step
SPRINGS = np.array([0.30, 0.30, 0.22, 0.18])  # shares of the bristle stiffness
LEVELS = np.array([0.15, 0.25, 0.28, 0.32])  # shares of the sliding friction


@njit(cache=True)
def level(v, dp, position, temperature_C, j):
    """g(v): dry friction while sliding."""
    g = j.coulomb * (1.0 + j.coulomb_slope * (temperature_C - 40.0))
    if j.ripple > 0.0:
        g *= 1.0 + j.ripple * np.sin(2.0 * np.pi * position / j.pitch)
    g += j.pressure_friction * abs(dp) + j.stiction * np.exp(-((v / j.stribeck) ** 2))
    if j.coulomb_difference != 0.0:
        g += 0.5 * j.coulomb_difference * np.sign(v)
    return max(g, 0.0)


@njit(cache=True)
def viscous(v, thin, j):
    c = j.viscous * (1.0 - j.viscous_share + j.viscous_share / thin)
    return (c + 0.5 * j.viscous_difference * np.sign(v)) * v


@njit(cache=True)
def element_force(z, v, g, j):
    """Force of the elements at deflections z (4) and of the micro-damping of what still sticks."""
    if g <= 0.0:
        return 0.0
    force = 0.0
    for i in range(ELEMENTS):
        most = g * LEVELS[i]
        force += min(max(j.bristle * SPRINGS[i] * z[i], -most), most)
    sticking = max(1.0 - (force / g) ** 2, 0.0)
    return force + j.bristle_damping * np.exp(-((v / j.fade) ** 2)) * sticking * v


@njit(cache=True)
def slip(z, g, j):
    """Let every element slip to its limit; done after each step."""
    for i in range(ELEMENTS):
        most = g * LEVELS[i] / (j.bristle * SPRINGS[i])
        z[i] = min(max(z[i], -most), most)


@njit(cache=True)
def bristle_rate(z, v, g, j):
    """LuGre's ż; where the bristles relax faster than a step can follow the rate is held there, at the same steady state."""
    if g < 1e-9:
        return 0.0
    relaxation = j.bristle * abs(v) / g
    return (v - relaxation * z) * min(1.0, FASTEST / max(relaxation, 1e-9))


@njit(cache=True)
def bristle_force(z, v, g, j):
    """LuGre without the viscous part; micro-damping fades with the velocity."""
    if g < 1e-9:
        return 0.0
    return j.bristle * z + j.bristle_damping * np.exp(-((v / j.fade) ** 2)) * bristle_rate(z, v, g, j)
