"""Oil, and hoses with structure, grow softer with temperature: β(T) = β (1 + slope (T − 40 °C)), slope negative."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, both
from config.schema.effect_entry import HydraulicEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class BulkModulusTemperature(HydraulicEntry):
    effect: Literal["bulk_modulus_temperature"]
    temperature_slope: float = quantity("1/K", "relative change of the oil's bulk modulus per kelvin above 40 degC", low=-0.02, high=0.02)
    hose_temperature_slope: float = quantity("1/K", "the same of hoses and structure", 0.0, low=-0.02, high=0.02)


EFFECT = Effect(
    entry=BulkModulusTemperature,
    order=180,
    writes=(
        Write("temperature_slope", J.BULK_SLOPE),
        Write("hose_temperature_slope", J.HOSE_SLOPE),
    ),
    neutral={"temperature_slope": 0.0, "hose_temperature_slope": 0.0},
    search=Search(Equation.FLOW, (both("temperature_slope", lambda s: 0.0035, 5),)),
    variable="acceleration",
    fingerprint="The hydraulic resonance falls as the oil warms, the low-frequency gain does not change.",
    look_alikes={
        "entrained_air": "air acts at low pressure",
        "hose_compliance": "hoses act at every temperature",
        "cross_leakage": "leakage changes damping and gain, not the resonance",
    },
    cases=(Case("rotary", {"temperature_slope": -0.01, "hose_temperature_slope": -0.01}, "rotary.position"),),
)
