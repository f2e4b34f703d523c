"""Return line: P_t = pressure + R Q²."""

from __future__ import annotations

from config.effects_hydraulic import ReturnBackPressure
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import C

EFFECT = Effect(
    entry=ReturnBackPressure,
    writes=(
        Write("pressure", C.RETURN_PRESSURE, added=True),
        Write("resistance", C.RETURN_RESISTANCE),
    ),
    neutral={"pressure": 0.0, "resistance": 0.0},
    fingerprint="The return pressure is raised, more so at high flow; both chambers stand higher.",
    look_alikes={
        "line_loss": "line loss lowers the supply pressure",
        "external_leakage": "leakage lowers the chambers",
    },
)
