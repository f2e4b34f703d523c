"""Hours of moving in one compiled call: joints held on given references by proportional servos with velocity feed-forward.

For what the machine's own work does to its oil: a servo of two numbers and true positions is enough for that, and 18 million control
periods (five hours) then take minutes instead of the hour that the whole controller would.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_backend import kernel
from sim_backend.compiled import compiled
from sim_backend.layout import D_STRIDE, SLOTS, D, H, Vector
from sim_backend.sensors import supply_port

Array = NDArray[np.float64]
COLUMNS = ("flow", "reservoir_temperature", "supply_temperature", "return_temperature", "metal_temperature")  # m³/s, degC


@compiled
def servo_run(
    x: Vector,
    p: Vector,
    w: Vector,
    scratch: tuple[Vector, Vector, Vector],
    references: Array,
    servos: Array,
    period_s: float,
    out: Array,
) -> None:
    """Advance by one period for every row of references (n × 4: position of both slots in rad or m, then their rates).

    `servos` (2 × 3): gain in V per rad or m, feed-forward in V per rad/s or m/s, largest command in V. A row of `out` every
    n // len(out) periods: means over them, since the ports' temperatures swing with the flow of every moment.
    """
    every = references.shape[0] // out.shape[0]
    taken = x[D.SUPPLY_VOLUME] + x[D_STRIDE + D.SUPPLY_VOLUME]
    volts, total = np.zeros(SLOTS), np.zeros(out.shape[1])
    for i in range(out.shape[0] * every):
        for slot in range(SLOTS):
            wanted = (
                servos[slot, 0] * (references[i, slot] - x[slot * D_STRIDE + D.POSITION]) + servos[slot, 1] * references[i, SLOTS + slot]
            )
            volts[slot] = min(max(wanted, -servos[slot, 2]), servos[slot, 2])
        kernel.advance(x, p, w, scratch, volts[0], volts[1], period_s)
        total[1] += x[H.RESERVOIR]
        total[2] += supply_port(x)
        total[3] += x[H.RETURN_OIL]
        total[4] += x[H.METAL]
        if (i + 1) % every == 0:
            before, taken = taken, x[D.SUPPLY_VOLUME] + x[D_STRIDE + D.SUPPLY_VOLUME]
            total[0] = (taken - before) / period_s
            out[i // every, :] = total / every
            total[:] = 0.0
