"""A force on a joint that is known as a table only: straight between its knots, constant outside of them."""

from __future__ import annotations

from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import J, Vector

VELOCITY, POSITION, COMMAND = 1.0, 2.0, 3.0  # of TABLE_INPUT; any other is the pressure difference


@compiled
def table_force(velocity: float, position: float, command_V: float, pressure_difference: float, p: Vector, j: int) -> float:
    """Force on the joint in its positive direction; for a joint with TABLE_KNOTS of at least 2."""
    chosen = p[j + J.TABLE_INPUT]
    at = velocity if chosen == VELOCITY else position if chosen == POSITION else command_V if chosen == COMMAND else pressure_difference
    x, y = j + J.TABLE_AT_0, j + J.TABLE_FORCE_0
    last = int(p[j + J.TABLE_KNOTS]) - 1
    if at <= p[x]:
        return float(p[y])
    for k in range(1, last + 1):
        if at < p[x + k]:
            return float(p[y + k - 1] + (at - p[x + k - 1]) / (p[x + k] - p[x + k - 1]) * (p[y + k] - p[y + k - 1]))
    return float(p[y + last])
