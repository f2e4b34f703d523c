"""Oil, and hoses with structure, grow softer with temperature: β(T) = β (1 + slope (T − 40 °C)), slope negative."""

from __future__ import annotations

from config.effects_hydraulic import BulkModulusTemperature
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=BulkModulusTemperature,
    writes=(
        Write("temperature_slope", J.BULK_SLOPE),
        Write("hose_temperature_slope", J.HOSE_SLOPE),
    ),
    neutral={"temperature_slope": 0.0, "hose_temperature_slope": 0.0},
    fingerprint="The hydraulic resonance falls as the oil warms, the low-frequency gain does not change.",
    look_alikes={
        "entrained_air": "air acts at low pressure",
        "hose_compliance": "hoses act at every temperature",
        "cross_leakage": "leakage changes damping and gain, not the resonance",
    },
)
