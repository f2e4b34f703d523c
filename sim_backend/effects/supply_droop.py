"""A real supply: P V^1.4 of the accumulator's gas is constant, dV_oil/dt = Q_pump − Q_valves − Q_relief.

Q_pump = Q_max clip((P_set − P)/band, 0, 1), lagged; Q_relief = K max(P − P_relief, 0). 1/V = 0 is an accumulator without end.
"""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import SupplyEntry
from config.schema.section import quantity
from sim_backend.memory.layout import C


class SupplyDroop(SupplyEntry):
    effect: Literal["supply_droop"]
    inverse_gas_volume: float = quantity("1/m^3", "1 / gas volume of the accumulator at supply pressure; 0 never droops", low=0, high=1e5)
    pump_flow_m3_per_s: float = quantity("m^3/s", "largest flow of the pressure-compensated pump", low=0, high=0.1)
    regulation_band_Pa: float = quantity(
        "Pa", "pressure below the set one at which the pump gives its largest flow", 689475.7, low=1e3, high=1e7
    )
    pump_lag_s: float = quantity("s", "time constant of the pump's compensator", 0.05, low=0.005, high=2)
    relief_pressure_Pa: float = quantity("Pa", "the relief valve opens", 15168465.0, low=0, high=60e6)
    relief_gain_m3_per_s_Pa: float = quantity("m^3/s/Pa", "relief flow per pressure above that", 2e-9, low=0, high=1e-6)


EFFECT = Effect(
    entry=SupplyDroop,
    order=210,
    writes=(
        Write("inverse_gas_volume", C.INVERSE_GAS_VOLUME),
        Write("pump_flow", C.PUMP_FLOW),
        Write("regulation_band", C.PUMP_BAND),
        Write("pump_lag", C.PUMP_LAG),
        Write("relief_pressure", C.RELIEF_PRESSURE),
        Write("relief_gain", C.RELIEF_GAIN),
    ),
    neutral={"inverse_gas_volume": 0.0},
    search=Search(
        Equation.SUPPLY,
        (up("inverse_gas_volume", lambda s: 433.0, 50, (1.0, 0.2)),),
        {"pump_flow": lambda s: 6.3e-4},
    ),
    fingerprint="The supply pressure of all valves falls together with the oil taken, and recovers with the pump.",
    look_alikes={
        "line_loss": "line loss falls at once with the flow and at one valve only",
        "valve_saturation": "the supply pressure stays",
    },
    cases=(Case("supply", {"inverse_gas_volume": 433, "pump_flow": 6e-4}, "rotary.supply_pressure"),),
)
