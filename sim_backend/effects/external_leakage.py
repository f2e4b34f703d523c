"""Laminar leakage from each chamber to the outside, q = C_e ν(40 °C)/ν(T) P."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import HydraulicEntry
from config.schema.section import quantity
from sim_backend.memory.layout import J


class ExternalLeakage(HydraulicEntry):
    effect: Literal["external_leakage"]
    conductance_m3_per_s_Pa: float = quantity("m^3/s/Pa", "laminar leakage of each chamber to the outside at 40 degC", low=0, high=1e-8)


EFFECT = Effect(
    entry=ExternalLeakage,
    order=170,
    writes=(Write("conductance", J.EXTERNAL_LEAKAGE),),
    neutral={"conductance": 0.0},
    search=Search(Equation.FLOW, (up("conductance", lambda s: 0.02 * s.area * s.velocity / s.pressure, 200, (1.0, 0.1)),)),
    variable="command_V",
    fingerprint="Both chamber pressures settle lower; more oil goes in than comes back.",
    look_alikes={
        "cross_leakage": "the mean of the chamber pressures falls, not only their difference",
        "return_back_pressure": "return pressure raises the mean of the chambers",
    },
    cases=(Case("prismatic", {"conductance": 1e-12}, "prismatic.pressure_a"),),
)
