"""Where a value lies in a table: straight lines between the points, constant beyond them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence


def between(points: Sequence[float], value: float) -> tuple[int, int, float]:
    """(index below, index above, share of the way from one to the other); twice the same index beyond the ends. `points` rise."""
    place = bisect_right(points, value)
    if place == 0 or place == len(points):
        end = min(place, len(points) - 1)
        return end, end, 0.0
    low = points[place - 1]
    return place - 1, place, (value - low) / (points[place] - low)
