"""The same rig with one thing different: how a figure's conditions are set without another rig file."""

from __future__ import annotations

from math import degrees
from typing import Any

from config.errors import PlantError
from config.schema.plant import Plant
from config.schema.rig import Rig

ROTARY, PRISMATIC = "rotary", "prismatic"  # the joints of the paper's arm


def plant_of(rig: Rig) -> Plant:
    """The plant section. Raises PlantError when the rig has none."""
    if rig.plant is None:
        raise PlantError("the rig has no section 'plant'", where=rig.name, next_step="The simulated backend needs one.")
    return rig.plant


def as_in_1997(rig: Rig) -> Rig:
    """The servo of the published figures: 0.35 V/deg and velocity feed-forward on the rotary joint, no end-point feedback, no dither."""
    still = with_servo(rig, "prismatic", oil_compensation=None)
    no_more = {"sections": (), "acceleration_feedforward": 0.0, "dither_V": 0.0, "oil_compensation": None, "link_notch": None}
    plain = with_servo(still, "rotary", gain=degrees(0.35), **no_more)
    return plain.model_copy(update={"end_point": None})


def without_effect(rig: Rig, effect: str) -> Rig:
    """The rig with every entry of this effect deleted."""
    plant = plant_of(rig)
    kept = tuple(entry for entry in plant.effects if entry.effect != effect)
    return rig.model_copy(update={"plant": plant.model_copy(update={"effects": kept})})


def with_valve(rig: Rig, joint: str, **changes: float) -> Rig:
    """The rig with other values of a joint's valve, by stored name: `null_adjustment=0.0`."""
    plant = plant_of(rig)
    valve: Any = getattr(plant.joints[joint], "valve", None)
    if valve is None:
        raise PlantError(f"plant.joints.{joint} has no valve", where=rig.name)
    changed = plant.joints[joint].model_copy(update={"valve": valve.model_copy(update=changes)})
    return rig.model_copy(update={"plant": plant.model_copy(update={"joints": {**plant.joints, joint: changed}})})


def with_link(rig: Rig, **changes: float) -> Rig:
    """The rig whose true link differs, by stored name: `payload_kg=20.0`. What the controller believes stays."""
    plant = plant_of(rig)
    if plant.link is None:
        raise PlantError("the rig has no link", where=rig.name)
    return rig.model_copy(update={"plant": plant.model_copy(update={"link": plant.link.model_copy(update=changes)})})


def with_servo(rig: Rig, joint: str, **changes: Any) -> Rig:
    """The rig with another servo of a joint, by stored name: `gain=28.6`."""
    return rig.model_copy(update={"servo": {**rig.servo, joint: rig.servo[joint].model_copy(update=changes)}})
