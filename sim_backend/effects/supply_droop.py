"""A real supply: P V^1.4 of the accumulator's gas is constant, dV_oil/dt = Q_pump − Q_valves − Q_relief.

Q_pump = Q_max clip((P_set − P)/band, 0, 1), lagged; Q_relief = K max(P − P_relief, 0). 1/V = 0 is an accumulator without end.
"""

from __future__ import annotations

from config.effects_hydraulic import SupplyDroop
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import C

EFFECT = Effect(
    entry=SupplyDroop,
    writes=(
        Write("inverse_gas_volume", C.INVERSE_GAS_VOLUME),
        Write("pump_flow", C.PUMP_FLOW),
        Write("regulation_band", C.PUMP_BAND),
        Write("pump_lag", C.PUMP_LAG),
        Write("relief_pressure", C.RELIEF_PRESSURE),
        Write("relief_gain", C.RELIEF_GAIN),
    ),
    neutral={"inverse_gas_volume": 0.0},
    fingerprint="The supply pressure of all valves falls together with the oil taken, and recovers with the pump.",
    look_alikes={
        "line_loss": "line loss falls at once with the flow and at one valve only",
        "valve_saturation": "the supply pressure stays",
    },
)
