"""Return line: P_t = pressure + R Q²."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import SupplyEntry
from config.schema.section import quantity
from sim_backend.memory.layout import C


class ReturnBackPressure(SupplyEntry):
    effect: Literal["return_back_pressure"]
    pressure_Pa: float = quantity("Pa", "return pressure at no flow", low=0, high=5e6)
    resistance_Pa_s2_per_m6: float = quantity("Pa*s^2/m^6", "return pressure per squared flow of each valve", 0.0, low=0, high=1e15)


EFFECT = Effect(
    entry=ReturnBackPressure,
    order=220,
    writes=(
        Write("pressure", C.RETURN_PRESSURE, added=True),
        Write("resistance", C.RETURN_RESISTANCE),
    ),
    neutral={"pressure": 0.0, "resistance": 0.0},
    search=Search(
        Equation.SUPPLY,
        (
            up("pressure", lambda s: 0.01 * s.pressure, 20),
            up("resistance", lambda s: 0.01 * s.pressure / 4e-7, 100),
        ),
    ),
    fingerprint="The return pressure is raised, more so at high flow; both chambers stand higher.",
    look_alikes={
        "line_loss": "line loss lowers the supply pressure",
        "external_leakage": "leakage lowers the chambers",
    },
    cases=(Case("supply", {"pressure": 2e5, "resistance": 1e11}, "rotary.return_pressure"),),
)
