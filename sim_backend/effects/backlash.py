"""Free play and spring of the drive train between actuator and load (gap 0: rigid).

T = K (θ_m − θ ∓ gap/2) + C (θ̇_m − θ̇) in contact and never pulling, 0 within the gap; part of the mass sits on the actuator's side.
"""

from __future__ import annotations

from config.effects_joint import Backlash
from sim_backend.effects.effect import Effect, Write
from sim_backend.layout import J


def _on_actuator(side: str) -> float:
    return 1.0 if side == "actuator" else 0.0


EFFECT = Effect(
    entry=Backlash,
    writes=(
        Write("gap", J.GAP),
        Write("stiffness", J.DRIVE_STIFFNESS),
        Write("damping", J.DRIVE_DAMPING),
        Write("actuator_mass", J.ACTUATOR_MASS),
        Write("sensor_on", J.SENSOR_ON_ACTUATOR, convert=_on_actuator),
    ),
    neutral={"gap": 0.0},
    fingerprint="Motion is lost by a fixed distance after each reversal of the load, whatever the speed.",
    look_alikes={
        "valve_deadband": (
            "small against large reversals: backlash loses distance, a dead band loses command; backlash shows only when the load reverses"
        ),
        "transport_delay": "a delay loses time: the distance lost scales with the speed",
        "valve_hysteresis": "hysteresis is lost in command, before the flow",
    },
)
