"""The table of a joint's oil compensation, from steady speeds at constant commands on the simulated rig at several temperatures.

At one temperature u = a·v + s·sign(v) + b over the speeds of ordinary moves: slope, friction, bias. The slope has a value for either
direction: a cylinder with areas A₁ and A₂ takes √(A₁/A₂) times the volts a speed on its way back (docs/method/plant.md, P10).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from config.errors import PlantError
from config.schema.rig import Rig
from sim_backend.memory.layout import C
from sim_backend.plant import SimulatedRig
from tuning.arrays import Floats

TEMPERATURES_C = (15.0, 25.0, 35.0, 45.0, 55.0, 65.0)
SHARES = (0.08, 0.16, 0.24, 0.32)  # of the joint's rate limit
RUN_S, MEASURED_S = 0.9, 0.3
PERIOD_S = 0.001
LEAST_SPREAD = 0.1  # of the speeds of one direction over their mean, else slope and friction look alike
SAME_SLOPE = 0.005


@dataclass(frozen=True, slots=True)
class OilRow:
    """One point of the table; slopes in V per rad/s or m/s, `slope_back` towards smaller positions."""

    temperature_C: float
    slope: float
    slope_back: float
    friction_V: float
    bias_V: float


def oil_table(rig: Rig, joint: str, temperatures_C: Sequence[float] = TEMPERATURES_C) -> list[OilRow]:
    """What the joint needs to move at a steady speed, by oil temperature. Raises PlantError on a rig without plant."""
    return [_row(rig, joint, temperature) for temperature in temperatures_C]


def as_override(rig: Rig, joint: str, source: str, rows: Sequence[OilRow]) -> str:
    """The table as a change of the rig file: servo.JOINT.oil_compensation={...}."""
    feedforward = rig.servo[joint].velocity_feedforward
    points = ", ".join(_point(row, feedforward) for row in rows)
    return f"servo.{joint}.oil_compensation={{source: {source}, points: [{points}]}}"


def _point(row: OilRow, feedforward: float) -> str:
    back = f"velocity_factor_back: {row.slope_back / feedforward:.4f}, " if abs(row.slope_back / row.slope - 1.0) > SAME_SLOPE else ""
    return (
        f"{{temperature: {row.temperature_C:g} degC, velocity_factor: {row.slope / feedforward:.4f}, {back}"
        f"friction: {row.friction_V:.4f} V, bias: {row.bias_V:.4f} V}}"
    )


def fitted_row(temperature_C: float, rates: Floats, volts: Floats) -> OilRow:
    """Least squares of u = a·v + s·sign(v) + b over steady speeds in both directions (rad/s or m/s, V).

    Where the speeds of one direction are too close to separate slope from friction, one slope serves both.
    """
    forth = rates > 0.0
    spread = [float(np.std(part) / np.mean(np.abs(part))) for part in (rates[forth], rates[~forth])]
    own = min(spread) > LEAST_SPREAD
    slopes = [np.where(forth, rates, 0.0), np.where(forth, 0.0, rates)] if own else [rates]
    columns = np.column_stack([*slopes, np.sign(rates), np.ones(len(rates))])
    *slope, friction, bias = (float(value) for value in np.linalg.lstsq(columns, volts, rcond=None)[0])
    return OilRow(temperature_C, slope[0], slope[-1], friction, bias)


def _row(rig: Rig, joint: str, temperature_C: float) -> OilRow:
    if rig.servo[joint].velocity_feedforward == 0.0:
        advice = f"Give servo.{joint}.velocity_feedforward: the voltages of the table are shares of what it takes for the rate limit."
        raise PlantError("no oil table without a velocity feed-forward", value=joint, where=rig.name, next_step=advice)
    full_V = rig.servo[joint].velocity_feedforward * rig.joints[joint].rate_limit
    volts = np.array([direction * share * full_V for direction in (1.0, -1.0) for share in SHARES])
    return fitted_row(temperature_C, np.array([steady_rate(rig, joint, float(u), temperature_C) for u in volts]), volts)


def steady_rate(rig: Rig, joint: str, command_V: float, temperature_C: float) -> float:
    """Steady rate under a constant command, through the middle of the travel; the link does not bend, nothing warms up."""
    plant = SimulatedRig(rig)
    values = plant.parameters.values
    values[C.BENDING_STIFFNESS] = values[C.THERMAL] = 0.0
    middle = [0.5 * sum(each.travel) for each in rig.joints.values()]
    column = plant.joints.index(joint)
    middle[column] -= 0.5 * command_V / rig.servo[joint].velocity_feedforward * RUN_S
    plant.reset(middle, temperature_C)
    commands = np.zeros((round(RUN_S / PERIOD_S), len(plant.joints)))
    commands[:, column] = command_V
    return float(np.mean(plant.run(commands, PERIOD_S)[f"{joint}.velocity"][-round(MEASURED_S / PERIOD_S) :]))
