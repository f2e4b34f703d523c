"""Fastest motion over a distance within a speed and an acceleration: trapezoid, or triangle when the distance is short.

|d| ≥ v²/a:  t_a = v/a, T = |d|/v + v/a        |d| < v²/a:  t_a = √(|d|/a), T = 2 t_a

The same move in the same time without corners in its acceleration: longer ramps u³(10 − 15u + 6u²) of a somewhat higher speed d/(T − r)
(the polynomial of least jerk: T. Flash and N. Hogan, J. Neuroscience 5, 1985).
"""

from __future__ import annotations

from math import copysign, sqrt

from servo_control.path.waves import smooth_step

STEEPEST = 1.875  # of the ramp u³(10 − 15u + 6u²), at its middle


class Trapezoid:
    """Closed form of s(t), ṡ(t), s̈(t) from 0 to `distance`; any unit. `speed` and `acceleration` as reached, `ramp_s` the time between."""

    __slots__ = ("_acceleration", "_cruise_start", "_speed", "acceleration", "distance", "duration_s", "ramp_s", "speed")

    def __init__(self, distance: float, speed: float, acceleration: float) -> None:
        length = abs(distance)
        peak = min(speed, sqrt(length * acceleration))
        self.distance, self.speed, self.acceleration = distance, peak, acceleration
        self.ramp_s = peak / acceleration
        self._speed = copysign(peak, distance)
        self._acceleration = copysign(acceleration, distance)
        self.duration_s = length / peak + self.ramp_s if peak > 0.0 else 0.0
        self._cruise_start = 0.5 * self._acceleration * self.ramp_s**2

    def at(self, t: float) -> tuple[float, float, float]:
        """(s, ṡ, s̈) at time t; at rest at 0 before and at `distance` after."""
        left = self.duration_s - t
        if t < 0.0 or self.duration_s == 0.0:
            return 0.0, 0.0, 0.0
        if left <= 0.0:
            return self.distance, 0.0, 0.0
        if t < self.ramp_s:
            return 0.5 * self._acceleration * t * t, self._acceleration * t, self._acceleration
        if left < self.ramp_s:
            return self.distance - 0.5 * self._acceleration * left * left, self._acceleration * left, -self._acceleration
        return self._cruise_start + self._speed * (t - self.ramp_s), self._speed, 0.0


class SmoothRamps:
    """Has what a `Trapezoid` has, takes as long, and nowhere jumps in acceleration."""

    __slots__ = ("_speed", "distance", "duration_s", "ramp_s")

    def __init__(self, distance: float, duration_s: float, ramp_s: float) -> None:
        """`ramp_s`: at most half the duration."""
        self.distance, self.duration_s, self.ramp_s = distance, duration_s, ramp_s
        self._speed = distance / (duration_s - ramp_s)

    def at(self, t: float) -> tuple[float, float, float]:
        """(s, ṡ, s̈) at time t; at rest at 0 before and at `distance` after."""
        left = self.duration_s - t
        if t <= 0.0:
            return 0.0, 0.0, 0.0
        if left <= 0.0:
            return self.distance, 0.0, 0.0
        if t < self.ramp_s:
            return self._ramp(t)
        if left < self.ramp_s:
            s, rate, acceleration = self._ramp(left)
            return self.distance - s, rate, -acceleration
        return self._speed * (t - 0.5 * self.ramp_s), self._speed, 0.0

    def _ramp(self, t: float) -> tuple[float, float, float]:
        u = t / self.ramp_s
        share, rate, _ = smooth_step(t, self.ramp_s)
        return self._speed * self.ramp_s * u**4 * (2.5 + u * (u - 3.0)), self._speed * share, self._speed * rate


def smoothed(path: Trapezoid, faster: float) -> Trapezoid | SmoothRamps:
    """Smooth ramps as long as a speed `faster` times as high allows; the trapezoid itself where they would be steeper than its own."""
    ramp_s = path.duration_s - abs(path.distance) / (faster * path.speed)
    if ramp_s > 0.5 * path.duration_s or STEEPEST * faster * path.speed > path.acceleration * ramp_s:
        return path
    return SmoothRamps(path.distance, path.duration_s, ramp_s)
