"""What a simulated hydraulic joint can do, from the sizes in its rig file alone: full speed, acceleration, natural frequency.

Closed forms of the ideal machine in mid-travel (Merritt, Hydraulic Control Systems, 1967, sections 6-1 and 6-4): flow of a valve
Q = Qn sqrt(p / pn); speed Q / A; stiffness of the trapped oil k = beta (A1²/V1 + A2²/V2); frequency sqrt(k / m) / 2 pi.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from config.schema.plant import Link, Plant
from config.schema.plant_joint import Cylinder, RotaryActuator
from config.schema.rig import Rig


@dataclass(frozen=True, slots=True)
class ActuatorSizes:
    """One joint in its units: m or rad for x, kg or kg m² for the mass, m² or m³/rad for the areas of chamber A and B."""

    unit: str
    stroke: float
    areas: tuple[float, float]
    volumes_m3: tuple[float, float]  # in mid-travel
    mass: float
    drop_Pa: float  # supply less return
    rated_flow_m3_per_s: float
    rated_pressure_drop_Pa: float
    full_scale_V: float
    bulk_modulus_Pa: float

    @property
    def full_flow_m3_per_s(self) -> float:
        """Through the open valve with no load."""
        return self.rated_flow_m3_per_s * math.sqrt(max(self.drop_Pa, 0.0) / self.rated_pressure_drop_Pa)

    @property
    def full_speed(self) -> float:
        """With the open valve and no load, mean of both directions."""
        return self.full_flow_m3_per_s / (0.5 * sum(self.areas))

    @property
    def largest_acceleration(self) -> float:
        """With the whole supply pressure on the larger area."""
        return self.drop_Pa * max(self.areas) / self.mass

    @property
    def natural_frequency_Hz(self) -> float:
        """Of the mass on the oil in both chambers."""
        stiffness = self.bulk_modulus_Pa * sum(area**2 / volume for area, volume in zip(self.areas, self.volumes_m3, strict=True))
        return math.sqrt(stiffness / self.mass) / (2 * math.pi)


def actuator_sizes(rig: Rig, name: str) -> ActuatorSizes | None:
    """None for a joint that is not hydraulic, or whose rig file leaves out supply, oil or mass."""
    plant = rig.plant
    joint = plant.joints.get(name) if plant else None
    if plant is None or plant.supply is None or plant.oil is None or not isinstance(joint, (Cylinder, RotaryActuator)):
        return None
    mass = _mass(rig, plant, name, joint)
    if mass <= 0:
        return None
    stroke = joint.travel[1] - joint.travel[0]
    areas, dead = _areas_and_volumes(joint)
    return ActuatorSizes(
        unit="m" if isinstance(joint, Cylinder) else "rad",
        stroke=stroke,
        areas=areas,
        volumes_m3=(dead[0] + 0.5 * stroke * areas[0], dead[1] + 0.5 * stroke * areas[1]),
        mass=mass,
        drop_Pa=plant.supply.pressure_Pa - plant.supply.return_pressure_Pa,
        rated_flow_m3_per_s=joint.valve.rated_flow_m3_per_s,
        rated_pressure_drop_Pa=joint.valve.rated_pressure_drop_Pa,
        full_scale_V=joint.valve.full_scale_V,
        bulk_modulus_Pa=plant.oil.bulk_modulus_Pa,
    )


def _areas_and_volumes(joint: Cylinder | RotaryActuator) -> tuple[tuple[float, float], tuple[float, float]]:
    """Areas, and the volumes that are left at the ends of the stroke."""
    if isinstance(joint, Cylinder):
        cap = 0.25 * math.pi * joint.bore_m**2
        return (cap, cap - 0.25 * math.pi * joint.rod_m**2), (joint.dead_volume_a_m3, joint.dead_volume_b_m3)
    middle, stroke, oil = 0.5 * sum(joint.travel), joint.travel[1] - joint.travel[0], joint.displacement_m3_per_rad
    at_middle = joint.volume_a_m3 + oil * middle, joint.volume_b_m3 - oil * middle
    left = tuple(max(volume - 0.5 * oil * stroke, 1e-7) for volume in at_middle)
    return (oil, oil), (left[0], left[1])


def _mass(rig: Rig, plant: Plant, name: str, joint: Cylinder | RotaryActuator) -> float:
    """What the joint moves: of an arm the link in mid-extension with its payload."""
    if rig.arm.kind == "single_axis":
        return joint.mass_kg if isinstance(joint, Cylinder) else joint.inertia_kg_m2
    if plant.link is None:
        return 0.0
    link = plant.link
    if isinstance(joint, Cylinder):
        return link.carriage_kg + link.payload_kg + link.mass_per_length_kg_per_m * link.total_length_m
    return _turned(link, rig.arm.hub_offset_m + 0.5 * sum(rig.joints["prismatic"].travel))


def _turned(link: Link, reach_m: float) -> float:
    """Turning inertia about the hub with the tip at `reach`."""
    tube_kg, length_m = link.mass_per_length_kg_per_m * link.total_length_m, link.total_length_m
    tube = tube_kg * ((reach_m - 0.5 * length_m) ** 2 + length_m**2 / 12)
    return link.hub_inertia_kg_m2 + tube + link.payload_inertia_kg_m2 + link.payload_kg * reach_m**2
