"""Fastest motion over a distance within a speed and an acceleration: trapezoid, or triangle when the distance is short.

|d| ≥ v²/a:  t_a = v/a, T = |d|/v + v/a        |d| < v²/a:  t_a = √(|d|/a), T = 2 t_a
"""

from __future__ import annotations

from math import copysign, sqrt


class Trapezoid:
    """Closed form of s(t), ṡ(t), s̈(t) from 0 to `distance`; any unit."""

    __slots__ = ("_acceleration", "_cruise_start", "_ramp_s", "_speed", "distance", "duration_s")

    def __init__(self, distance: float, speed: float, acceleration: float) -> None:
        length = abs(distance)
        peak = min(speed, sqrt(length * acceleration))
        self.distance = distance
        self._ramp_s = peak / acceleration
        self._speed = copysign(peak, distance)
        self._acceleration = copysign(acceleration, distance)
        self.duration_s = length / peak + self._ramp_s if peak > 0.0 else 0.0
        self._cruise_start = 0.5 * self._acceleration * self._ramp_s**2

    def at(self, t: float) -> tuple[float, float, float]:
        """(s, ṡ, s̈) at time t; at rest at 0 before and at `distance` after."""
        left = self.duration_s - t
        if t < 0.0 or self.duration_s == 0.0:
            return 0.0, 0.0, 0.0
        if left <= 0.0:
            return self.distance, 0.0, 0.0
        if t < self._ramp_s:
            return 0.5 * self._acceleration * t * t, self._acceleration * t, self._acceleration
        if left < self._ramp_s:
            return self.distance - 0.5 * self._acceleration * left * left, self._acceleration * left, -self._acceleration
        return self._cruise_start + self._speed * (t - self._ramp_s), self._speed, 0.0
