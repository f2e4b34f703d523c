"""How fast a joint may move so that it can still stop in time, in whole cycles.

A joint that moves u in a cycle and slows down by q = a T² from one cycle to the next goes

    (J1)  S(u) = u + (u − q) + … = (n + 1) u − q n (n + 1)/2,   n = floor(u/q)

before it rests. Solved for u, with n from q n (n + 1)/2 ≤ d < q (n + 1)(n + 2)/2:

    (J2)  u = (d + q n (n + 1)/2)/(n + 1)

u is continuous in d, and S(u) = d: a joint that never moves faster stops at the limit and not a bit beyond it.
For long ways it is the usual v = √(2 a d).
"""

from __future__ import annotations

from math import sqrt


def fastest(distance: float, acceleration: float, period_s: float) -> float:
    """Largest rate from which a joint rests after `distance` (rad or m) with `acceleration` (per s²); 0 where there is no way left."""
    if distance <= 0.0:
        return 0.0
    step = acceleration * period_s * period_s
    n = int(0.5 * (sqrt(1.0 + 8.0 * distance / step) - 1.0))
    return (distance + 0.5 * step * n * (n + 1)) / ((n + 1) * period_s)
