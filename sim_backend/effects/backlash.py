"""Free play and spring of the drive train between actuator and load (gap 0: rigid).

T = K (θ_m − θ ∓ gap/2) + C (θ̇_m − θ̇) in contact and never pulling, 0 within the gap; part of the mass sits on the actuator's side.
"""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Freedom, Search, Write, up
from config.schema.effect_entry import DAMPING, LENGTH, MASS, STIFFNESS, JointEntry, quantity_by_place
from sim_backend.memory.layout import J


class Backlash(JointEntry):
    effect: Literal["backlash"]
    gap: float = quantity_by_place(LENGTH, "total free play between actuator and load; 0 is a rigid drive train", low=0, high=0.2)
    stiffness: float = quantity_by_place(STIFFNESS, "drive train in contact", low=1, high=1e9)
    damping: float = quantity_by_place(DAMPING, "drive train in contact", 0.0, low=0, high=1e6)
    actuator_mass: float = quantity_by_place(MASS, "share of the joint's mass or inertia on the actuator's side", low=1e-9, high=1e5)
    sensor_on: Literal["actuator", "load"] = "load"


def _on_actuator(side: str) -> float:
    return 1.0 if side == "actuator" else 0.0


EFFECT = Effect(
    entry=Backlash,
    order=60,
    writes=(
        Write("gap", J.GAP),
        Write("stiffness", J.DRIVE_STIFFNESS),
        Write("damping", J.DRIVE_DAMPING),
        Write("actuator_mass", J.ACTUATOR_MASS),
        Write("sensor_on", J.SENSOR_ON_ACTUATOR, convert=_on_actuator),
    ),
    neutral={"gap": 0.0},
    search=Search(
        Equation.FORCE,
        (
            up("gap", lambda s: 0.001 * s.length, 50, (1.0, 4.0)),
            Freedom("stiffness", lambda s: 0.5 * s.stiffness, lambda s: 0.02 * s.stiffness, lambda s: 10 * s.stiffness),
            Freedom("actuator_mass", lambda s: 0.15 * s.mass, lambda s: 0.01 * s.mass, lambda s: 0.9 * s.mass),
        ),
        {"damping": lambda s: 0.02 * (s.stiffness * s.mass) ** 0.5},
    ),
    fingerprint="Motion is lost by a fixed distance after each reversal of the load, whatever the speed.",
    look_alikes={
        "valve_deadband": (
            "small against large reversals: backlash loses distance, a dead band loses command; backlash shows only when the load reverses"
        ),
        "transport_delay": "a delay loses time: the distance lost scales with the speed",
        "valve_hysteresis": "hysteresis is lost in command, before the flow",
    },
    cases=(
        Case("rotary", {"gap": 0.004, "stiffness": 1.5e5, "damping": 100, "actuator_mass": 2}, "rotary.position"),
        Case("prismatic", {"gap": 0.0005, "stiffness": 1e7, "actuator_mass": 5}, "prismatic.position"),
    ),
)
