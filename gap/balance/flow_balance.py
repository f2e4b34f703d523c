"""The flow balance of one chamber, (P7) of docs/method/plant.md, over the supports of a log."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gap.balance.log_signals import LogSignals, spool
from gap.balance.weak_form import Bump, Sum, supports
from gap.data.measured import Array
from sim_backend.memory.layout import J_START, J_STRIDE, C, J
from sim_backend.physics.chambers import compliance, cross_flow
from sim_backend.physics.valve import land_flow, openings


def flow_balance(log: LogSignals, where: str, test: Bump, starts: NDArray[np.int64]) -> tuple[Sum, Array]:
    """flow through the lands − area × velocity − leakage − compliance × d/dt pressure = 0, for chamber A or B."""
    joint, _, chamber = where.partition(".")
    first = chamber == "pressure_a"
    p, j, rows = log.p, J_START + log.slots[joint] * J_STRIDE, test.rows
    pressure, position = log.signals[where], log.signals[f"{joint}.position"]
    done = Sum(len(starts))
    done.add(1.0, test.value, supports(_land_flows(log, joint, j, pressure, first), starts, rows))
    area = p[j + J.AREA_A] if first else -p[j + J.AREA_B]
    done.add(-area, test.rate, supports(position, starts, rows), log.sigma[f"{joint}.position"])
    other = log.signals.get(f"{joint}.pressure_b" if first else f"{joint}.pressure_a")
    if other is not None:
        a, b = (pressure, other) if first else (other, pressure)
        leak = np.array([cross_flow(p[j + J.CROSS_LEAKAGE], a[k], b[k], p, j) for k in range(len(a))])
        done.add(-1.0 if first else 1.0, test.value, supports(leak, starts, rows))
    done.add(-p[j + J.EXTERNAL_LEAKAGE], test.value, supports(pressure, starts, rows))
    middle = starts + rows // 2
    travel = position[middle] - p[j + J.VOLUME_POSITION]
    volume = (p[j + J.VOLUME_A] if first else p[j + J.VOLUME_B]) + area * travel
    soft = np.array([compliance(pressure[k], p[C.BULK_MODULUS], p[j + J.HOSE_COMPLIANCE], p, j) for k in middle])
    done.add(-volume * soft, test.rate, supports(pressure, starts, rows), log.sigma[where])
    return done, np.ones(len(starts), dtype=bool)


def _land_flows(log: LogSignals, joint: str, j: int, pressure: Array, first: bool) -> Array:
    """Flow into a chamber at every row."""
    p, asked = log.p, spool(log, joint, j)
    supply = log.signals.get(f"{joint}.supply_pressure", np.full(len(asked), p[C.SUPPLY_PRESSURE]))
    tank = log.signals.get(f"{joint}.return_pressure", np.full(len(asked), p[C.RETURN_PRESSURE]))
    laminar, found = p[j + J.LAMINAR_PRESSURE] ** 2, np.empty(len(asked))
    for k in range(len(asked)):
        opened, closed = openings(asked[k], p, j)
        into, out = (opened, closed) if first else (closed, opened)
        found[k] = into * land_flow(supply[k] - pressure[k], laminar) - out * land_flow(pressure[k] - tank[k], laminar)
    return np.asarray(p[j + J.FLOW_COEFFICIENT] * found)
