"""Hours of warming up: the heat stores alone, driven by a given valve flow."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from config.errors import PlantError
from config.schema.rig import Rig
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import STATES, C, H, Vector
from sim_backend.physics.sensors import supply_port
from sim_backend.physics.thermal import thermal_step


def warm_up(rig: Rig, valve_flow_m3_per_s: ArrayLike, period_s: float, start_C: float) -> dict[str, NDArray[np.float64]]:
    """Temperatures (degC) for a valve flow given every period_s (s); oil, hose and metal start at start_C.

    Returns `t_s`, `reservoir_temperature`, `supply_temperature` (at the valve's port), `return_temperature`, `metal_temperature`,
    each with the length of the flow, at the end of each period.
    """
    p = Parameters(rig).values
    if p[C.THERMAL] == 0.0:
        raise PlantError("the plant has no thermal section", where=rig.name, next_step="Add plant.thermal.")
    flow = np.asarray(valve_flow_m3_per_s, dtype=np.float64)
    x = np.zeros(STATES)
    x[H.RESERVOIR : H.OIL + 1] = start_C
    out = np.empty((flow.size, 4))
    _warm(x, p, flow, period_s, out)
    names = ("reservoir_temperature", "supply_temperature", "return_temperature", "metal_temperature")
    columns = {name: out[:, i] for i, name in enumerate(names)}
    return {"t_s": period_s * np.arange(1, flow.size + 1, dtype=np.float64), **columns}


@compiled
def _warm(x: Vector, p: Vector, flow: Vector, period_s: float, out: NDArray[np.float64]) -> None:
    for i in range(flow.size):
        thermal_step(x, flow[i], p[C.SUPPLY_PRESSURE], p, period_s)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = x[H.RESERVOIR], supply_port(x), x[H.RETURN_OIL], x[H.METAL]
