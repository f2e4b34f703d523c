"""Five hours of warming up with moves in between: how far the joints lag behind their references as the oil gets thin.

The heat stores run through all of the schedule; at every asked moment the whole rig (controller, sensors, hydraulics, link) starts from
their state, holds until the temperature sensors have settled, and makes the move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from config.rig import Rig
from control.run_plan import RunPlan
from sim_backend.layout import C, H
from sim_backend.plant import SimulatedRig
from sim_backend.thermal import thermal_step
from tuning.line_run import coupled_run
from tuning.transfer import Floats

SETTLING_S = 15.0  # holding before the move: three lags of the temperature sensors
SCHEDULE_PERIOD_S = 1.0


@dataclass(frozen=True, slots=True)
class Lag:
    """One move at `t_s` of the schedule with the oil at `oil_C`: error reference − position over the moves, per joint (rad, m)."""

    t_s: float
    oil_C: float
    rms: tuple[float, ...]
    largest: tuple[float, ...]


def heat_at(rig: Rig, valve_flow_m3_per_s: Floats, moments_s: Sequence[float], start_C: float) -> list[Floats]:
    """Temperatures of the heat stores (RESERVOIR to OIL of the state vector) at the moments, for a flow given every second."""
    plant = SimulatedRig(rig)
    plant.reset(None, start_C)
    state, values = plant.state, plant.parameters.values
    found, wanted = [], sorted(round(moment / SCHEDULE_PERIOD_S) for moment in moments_s)
    for second in range(wanted[-1] + 1):
        while wanted and wanted[0] == second:
            found.append(state[H.RESERVOIR : H.OIL + 1].copy())
            wanted.pop(0)
        flow = valve_flow_m3_per_s[min(second, len(valve_flow_m3_per_s) - 1)]
        thermal_step(state, float(flow), float(values[C.SUPPLY_PRESSURE]), values, SCHEDULE_PERIOD_S)
    return found


def lags(rig: Rig, plan: RunPlan, moments_s: Sequence[float], heat: Sequence[Floats]) -> list[Lag]:
    """The move at every moment, from the heat stores' state at that moment."""
    return [_lag(rig, plan, moment, state) for moment, state in zip(moments_s, heat, strict=True)]


def _lag(rig: Rig, plan: RunPlan, t_s: float, heat: Floats) -> Lag:
    run = coupled_run(rig, plan, heat_C=heat, holding_s=SETTLING_S)
    moving = np.zeros(len(run.reference), dtype=bool)
    for segment in run.plan.segments:
        if segment.kind == "move":
            moving[round(segment.start_s / run.period_s) : round(segment.end_s / run.period_s)] = True
    error = (run.reference - run.position)[moving]
    rms, largest = np.sqrt(np.mean(error**2, axis=0)), np.max(np.abs(error), axis=0)
    return Lag(t_s, float(heat[-1]), tuple(map(float, rms)), tuple(map(float, largest)))
