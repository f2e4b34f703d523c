"""Supply and return: pump, accumulator, relief valve, hoses ((P11) to (P13) of docs/method/plant.md)."""

from __future__ import annotations

from config.schema.effect import Hook
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import C, Vector, X
from sim_backend.physics.laws import hooked

_supplied = hooked(Hook.SUPPLY)

GAS_EXPONENT = 1.4
LINE_RATE = 500.0  # 1/s, from the inertia of the oil in a hose; makes the flow that loses pressure a state


@compiled
def valve_supply(accumulator_Pa: float, line_flow: float, p: Vector) -> float:
    """Supply pressure at a valve: the accumulator's less the hose's quadratic loss."""
    return float(_supplied(accumulator_Pa - p[C.LINE_RESISTANCE] * line_flow * abs(line_flow), (line_flow,), 0, p))


@compiled
def valve_return(return_flow: float, p: Vector) -> float:
    """Return pressure at a valve."""
    return float(p[C.RETURN_PRESSURE] + p[C.RETURN_RESISTANCE] * return_flow * abs(return_flow))


@compiled
def supply_rates(y: Vector, valve_flow: float, p: Vector, d: Vector) -> None:
    """Write the derivatives of accumulator pressure, gas volume ratio and pump flow.

    P V^1.4 is constant along dP = −1.4 P/V dV, so pressure and volume are both states and no power is needed.
    Without a gas volume (effect supply_droop) the supply is ideal and these states stand still.
    """
    if p[C.INVERSE_GAS_VOLUME] == 0.0:
        return
    pressure, ratio = y[X.SUPPLY_PRESSURE], y[X.GAS_RATIO]
    demand = min(max((p[C.SUPPLY_PRESSURE] - pressure) / p[C.PUMP_BAND], 0.0), 1.0)
    d[X.PUMP_FLOW] = (p[C.PUMP_FLOW] * demand - y[X.PUMP_FLOW]) / p[C.PUMP_LAG]
    relief = p[C.RELIEF_GAIN] * max(pressure - p[C.RELIEF_PRESSURE], 0.0)
    oil_in = y[X.PUMP_FLOW] - valve_flow - relief
    d[X.GAS_RATIO] = -p[C.INVERSE_GAS_VOLUME] * oil_in
    d[X.SUPPLY_PRESSURE] = -GAS_EXPONENT * pressure / ratio * d[X.GAS_RATIO]
