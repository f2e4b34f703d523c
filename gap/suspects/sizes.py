"""What is large for a place of a rig: the yardsticks by which effects there are plausible."""

from __future__ import annotations

from config.schema.effect import Sizes
from config.schema.plant import Plant
from config.schema.plant_joint import Crosshead, Cylinder, RotaryActuator, Turntable
from config.schema.rig import Rig

HELD_PRESSURE_PA = 1e6  # yardstick of a rod pressed into a held chamber


def sizes_of(rig: Rig, plant: Plant, where: str) -> Sizes:
    pressure = plant.supply.pressure_Pa if plant.supply else 1e7
    if where.startswith("sensor:"):
        sensor = plant.sensors[where.removeprefix("sensor:")]
        return Sizes(noise=max(sensor.noise, sensor.resolution / 3), span=sensor.high - sensor.low)
    if where in ("supply", "link"):
        payload = plant.link.payload_kg if plant.link else 0.0
        bending = rig.link_mode.bending_stiffness_N_m2 if rig.link_mode else 3000.0
        return Sizes(pressure=pressure, payload=max(payload, 2.0), bending=bending)
    joint, limits = plant.joints[where], rig.joints[where]
    area, force = _drive(joint, pressure)
    return Sizes(
        force=force, velocity=limits.rate_limit, mass=_mass(plant, where), area=area, pressure=pressure, slow=joint.bristle_fade,
        stiffness=joint.bristle_stiffness,
    )  # fmt: skip


def _drive(joint: object, pressure: float) -> tuple[float, float]:
    """Area and force at full supply pressure, or at full command."""
    if isinstance(joint, RotaryActuator):
        return joint.displacement_m3_per_rad, joint.displacement_m3_per_rad * pressure
    if isinstance(joint, Cylinder):
        area = 0.785 * joint.bore_m**2
        return area, area * pressure
    if isinstance(joint, Crosshead):
        return joint.area_m2, joint.area_m2 * HELD_PRESSURE_PA
    if isinstance(joint, Turntable):
        return 1.0, 1.0  # nothing drives it but what it was measured to do
    gain = getattr(joint, "gain_N_per_V", None) or getattr(joint, "gain_N_m_per_V", 1.0)
    return 1.0, abs(gain * joint.full_scale_V)  # type: ignore[attr-defined]


def _mass(plant: Plant, where: str) -> float:
    joint = plant.joints[where]
    own = getattr(joint, "mass_kg", 0.0) or getattr(joint, "inertia_kg_m2", 0.0)
    if own or plant.link is None:
        return float(own or 1.0)
    link = plant.link
    if joint.motion == "rotary":
        return link.hub_inertia_kg_m2 + link.payload_kg
    return link.carriage_kg + link.payload_kg + link.mass_per_length_kg_per_m * link.total_length_m
