"""Laminar leakage from each chamber to the outside, q = C_e ν(40 °C)/ν(T) P."""

from __future__ import annotations

from config.effects_hydraulic import ExternalLeakage
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J

EFFECT = Effect(
    entry=ExternalLeakage,
    writes=(Write("conductance", J.EXTERNAL_LEAKAGE),),
    neutral={"conductance": 0.0},
    fingerprint="Both chamber pressures settle lower; more oil goes in than comes back.",
    look_alikes={
        "cross_leakage": "the mean of the chamber pressures falls, not only their difference",
        "return_back_pressure": "return pressure raises the mean of the chambers",
    },
)
