"""Seal friction that grows with the load: g(v) = F_c + c |P_A − P_B| + … (seals are pressed on by the pressure difference)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from config.schema.effect import Case, Effect, Equation, Search, Write, up
from config.schema.effect_entry import FORCE_PER_PRESSURE, HydraulicEntry, quantity_by_place
from config.schema.plant_joint import Crosshead, PlantJoint
from sim_backend.memory.layout import J


class PressureFriction(HydraulicEntry):
    effect: Literal["pressure_friction"]
    coefficient: float = quantity_by_place(FORCE_PER_PRESSURE, "seal friction per pressure difference between the chambers", low=0, high=1)

    def obstacles(self, joint: PlantJoint) -> Iterator[str]:
        if isinstance(joint, Crosshead) and joint.area_m2 > 0:
            return  # a rod in a held chamber has no valve and no flow, but a seal
        yield from super().obstacles(joint)


EFFECT = Effect(
    entry=PressureFriction,
    order=50,
    writes=(Write("coefficient", J.PRESSURE_FRICTION),),
    neutral={"coefficient": 0.0},
    search=Search(Equation.FORCE, (up("coefficient", lambda s: 0.03 * s.area, 20),), at_held_rod=True),
    fingerprint="The jump of the force residual at velocity reversal is larger when the pressure difference is larger.",
    look_alikes={
        "coulomb_friction": "repeat at two loads or supply pressures: Coulomb friction stays the same",
        "viscous_friction": "same speed at two loads",
    },
    cases=(Case("prismatic", {"coefficient": 1e-4}, "prismatic.position"),),
)
