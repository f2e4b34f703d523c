"""Rows in which a joint is pressed on the end of its travel: the stop takes whatever force there is, so they tell nothing of the joint.

A joint that merely waits near an end, with its command about zero, is no such row: its other numbers still hold.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from config.schema.rig import Rig
from gap.data.measured import Array, Measured
from gap.data.uniform_grid import bridged, runs

NEAR = 0.02  # of the travel: a data sheet's stroke and the machine's stop are seldom the same
PRESSING = 0.05  # of the command's full scale, towards the stop
_REST_S = 0.1
_STILL = 0.002  # of the travel in _REST_S


def at_stop(log: Measured, rig: Rig) -> NDArray[np.bool_]:
    """Rows × joints (order of rig.joints)."""
    return np.column_stack([_joint_at_stop(log, rig, number, joint) for number, joint in enumerate(rig.joints)])


def _joint_at_stop(log: Measured, rig: Rig, number: int, joint: str) -> NDArray[np.bool_]:
    plant: Any = rig.plant.joints[joint] if rig.plant else None
    channel = log.channels.get(f"{joint}.position")
    found = np.zeros(log.rows, dtype=np.bool_)
    if plant is None or plant.is_imposed or channel is None:
        return found
    low, high = plant.travel
    position, span = bridged(channel.values), high - low
    full_V = float(plant.valve.full_scale_V if hasattr(plant, "valve") else plant.full_scale_V)
    resting = _resting(position, max(round(_REST_S / log.period_s), 2), _STILL * span)
    for near, towards in ((position <= low + NEAR * span, -1.0), (position >= high - NEAR * span, 1.0)):
        for start, length in runs(resting & near):
            stay = slice(start, start + length)
            found[stay] = bool(np.any(towards * log.commands_V[stay, number] > PRESSING * full_V))
    return found


def _resting(position: Array, rows: int, most: float) -> NDArray[np.bool_]:
    """Rows of every stretch of `rows` rows over which the position changes by `most` at most."""
    still = np.zeros(len(position), dtype=np.bool_)
    for start in range(0, len(position) - rows, max(rows // 2, 1)):
        stretch = position[start : start + rows]
        if np.all(np.isfinite(stretch)) and np.ptp(stretch) <= most:
            still[start : start + rows] = True
    return still
