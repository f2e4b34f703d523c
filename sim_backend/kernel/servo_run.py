"""Hours of moving in one compiled call: joints held on given references by proportional servos with velocity feed-forward.

For what the machine's own work does to its oil: a servo of two numbers and true positions is enough for that, and 18 million control
periods (five hours) then take minutes instead of the hour that the whole controller would.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_backend.kernel import kernel
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import D_STRIDE, SLOTS, D, H, Vector
from sim_backend.physics.sensors import supply_port

Array = NDArray[np.float64]
COLUMNS = ("flow", "reservoir_temperature", "supply_temperature", "return_temperature", "metal_temperature")  # m³/s, degC


@compiled
def servo_volts(x: Vector, references: Array, servos: Array, i: int, slot: int) -> float:
    """Command of one slot's servo to the references of row i."""
    wanted = servos[slot, 0] * (references[i, slot] - x[slot * D_STRIDE + D.POSITION]) + servos[slot, 1] * references[i, SLOTS + slot]
    return float(min(max(wanted, -servos[slot, 2]), servos[slot, 2]))


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
    stay = kernel.rates_stay(p)
    taken = x[D.SUPPLY_VOLUME] + x[D_STRIDE + D.SUPPLY_VOLUME]
    for row in range(out.shape[0]):
        out[row, :] = 0.0
        for i in range(row * every, (row + 1) * every):
            volts_0, volts_1 = servo_volts(x, references, servos, i, 0), servo_volts(x, references, servos, i, 1)
            kernel.advance(x, p, w, scratch, volts_0, volts_1, period_s, stay and row + i > 0)
            out[row, 1] += x[H.RESERVOIR]
            out[row, 2] += supply_port(x)
            out[row, 3] += x[H.RETURN_OIL]
            out[row, 4] += x[H.METAL]
        before, taken = taken, x[D.SUPPLY_VOLUME] + x[D_STRIDE + D.SUPPLY_VOLUME]
        out[row, 0] = (taken - before) / period_s
        for column in range(out.shape[1]):
            out[row, column] /= every
