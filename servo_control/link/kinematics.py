"""Plane kinematics of the rotary-prismatic arm with hub offset a.

Rotary position p is 0 at mid stroke (arm along +Y) and positive anticlockwise, so p = q_r − 90° with q_r from the +X axis, and

    r = a + L,   x = −r sin p,   y = r cos p;     r = √(x² + y²),   p = −atan2(x, y)
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, hypot, sin


@dataclass(frozen=True, slots=True)
class JointMotion:
    """Positions, rates and accelerations of (rotary, prismatic) in rad and m."""

    position: tuple[float, float]
    rate: tuple[float, float]
    acceleration: tuple[float, float]


def forward(rotary: float, extension: float, hub_offset_m: float = 0.0) -> tuple[float, float]:
    """Tip point (x, y) in m of the rigid arm."""
    r = hub_offset_m + extension
    return -r * sin(rotary), r * cos(rotary)


def inverse(x: float, y: float, hub_offset_m: float = 0.0) -> tuple[float, float]:
    """(rotary, extension) that put the tip at (x, y)."""
    return 0.0 - atan2(x, y), hypot(x, y) - hub_offset_m


def forward_rates(position: tuple[float, float], rate: tuple[float, float], hub_offset_m: float = 0.0) -> tuple[float, float]:
    """Tip velocity (m/s) for joint positions and rates."""
    r = hub_offset_m + position[1]
    s, c = sin(position[0]), cos(position[0])
    return -rate[1] * s - r * rate[0] * c, rate[1] * c - r * rate[0] * s


def joint_rates(position: tuple[float, float], velocity: tuple[float, float], hub_offset_m: float = 0.0) -> tuple[float, float]:
    """Rates of (rotary, extension) that move the tip at `velocity` (m/s): the inverse of forward_rates."""
    s, c = sin(position[0]), cos(position[0])
    return -(velocity[0] * c + velocity[1] * s) / (hub_offset_m + position[1]), velocity[1] * c - velocity[0] * s


def inverse_motion(
    point: tuple[float, float], velocity: tuple[float, float], acceleration: tuple[float, float], hub_offset_m: float = 0.0
) -> JointMotion:
    """Joint positions, rates and accelerations of a tip motion (m, m/s, m/s²); exact, singular only at the hub axis."""
    (x, y), (vx, vy), (ax, ay) = point, velocity, acceleration
    r = hypot(x, y)
    r_rate = (x * vx + y * vy) / r
    angle_rate = (x * vy - y * vx) / (r * r)
    r_acceleration = (x * ax + y * ay) / r + r * angle_rate * angle_rate
    angle_acceleration = (x * ay - y * ax) / (r * r) - 2.0 * r_rate * angle_rate / r
    return JointMotion((0.0 - atan2(x, y), r - hub_offset_m), (angle_rate, r_rate), (angle_acceleration, r_acceleration))
