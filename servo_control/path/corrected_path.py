"""A path whose time law is corrected within the move: s(t) + Σ c_i B_i(t), cubic B-splines with equal knots over a span of it
(C. de Boor, A Practical Guide to Splines, 1978).

Every spline lies wholly within the span, so position, speed and acceleration at both ends are those of the path below it, and so is the
duration. Only the time law changes: both joints stay on the line.
"""

from __future__ import annotations

from collections.abc import Sequence

from servo_control.path.trajectory import SmoothRamps, Trapezoid

SPAN = 4  # knots a cubic spline covers


def bump(x: float) -> tuple[float, float, float]:
    """Cubic B-spline over 0 … 4 with its first and second derivative; the values at whole numbers are 0, 1/6, 4/6, 1/6, 0."""
    if x <= 0.0 or x >= 4.0:
        return 0.0, 0.0, 0.0
    y, sign = (x, 1.0) if x <= 2.0 else (4.0 - x, -1.0)
    if y <= 1.0:
        return y * y * y / 6.0, sign * 0.5 * y * y, y
    z = y - 1.0
    return (1.0 + 3.0 * z + 3.0 * z * z - 3.0 * z * z * z) / 6.0, sign * (0.5 + z - 1.5 * z * z), 1.0 - 3.0 * z


class CorrectedPath:
    """Has what a `Trapezoid` has; `coefficients` in the unit of the path, one for every spline; `span` (s): the whole move by default."""

    __slots__ = ("_base", "_coefficients", "_knot_s", "_span", "distance", "duration_s")

    def __init__(
        self, base: Trapezoid | SmoothRamps | CorrectedPath, coefficients: Sequence[float], span: tuple[float, float] | None = None
    ) -> None:
        self.distance: float = base.distance
        self.duration_s: float = base.duration_s
        self._base = base
        self._coefficients = tuple(coefficients)
        self._span = span or (0.0, base.duration_s)
        self._knot_s = (self._span[1] - self._span[0]) / (len(self._coefficients) + SPAN - 1)

    def at(self, t: float) -> tuple[float, float, float]:
        """(s, ṡ, s̈) at time t."""
        s, rate, acceleration = self._base.at(t)
        begin, end = self._span
        if not begin < t < end:
            return s, rate, acceleration
        place = (t - begin) / self._knot_s
        newest = int(place)
        for i in range(max(0, newest - SPAN + 1), min(newest, len(self._coefficients) - 1) + 1):
            value, slope, bend = bump(place - i)
            s += self._coefficients[i] * value
            rate += self._coefficients[i] * slope / self._knot_s
            acceleration += self._coefficients[i] * bend / self._knot_s**2
        return s, rate, acceleration


Path = Trapezoid | SmoothRamps | CorrectedPath
