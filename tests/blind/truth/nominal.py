"""The rig file's numbers as the hidden machine's, then every one of them wrong by up to 2 to 20 % as its provenance allows."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from config.schema.plant import Plant
from config.schema.plant_joint import Cylinder, RotaryActuator
from config.schema.rig import Rig
from tests.blind.truth.effects import EFFECTS
from tests.blind.truth.machine import Joint, Machine

Numbers = dict[str, float]
NEUTRAL = {"saturation": 1.0, "stribeck": 0.02, "pitch": 1.0, "lag_damping": 0.8, "actuator_mass": 1.0}
# Largest error by what the number is: stated by the paper, read in a catalogue, fitted to data, typical or assumed.
STATED, CATALOGUE, FITTED, ASSUMED = 0.02, 0.03, 0.10, 0.20
_EXACT = ("low", "high", "saturation", "friction_form", "volume_at", "pitch", "hub_offset", "relief", "viscosity_a", "vapour")
_STATED = ("area_a", "area_b", "supply", "payload", "tube_length", "viscosity_b")
_CATALOGUE = ("mass_per_length", "bending")
_ASSUMED = (
    "rotary.volume_a", "rotary.volume_b", "prismatic.volume_a", "prismatic.volume_b", "stop_stiffness", "slew", "rounding", "laminar",
    "coulomb_slope", "hysteresis", "air", "bristle", "bristle_damping", "fade", "stiction", "stribeck", "carriage", "damping", "line_rate",
    "bulk_slope", "hose_slope", "bulk_pressure", "viscous_share", "pump_band", "pump_lag",
)  # fmt: skip


def nominal(rig: Rig) -> Numbers:
    """Flat numbers `rotary.area_a`, `supply`, ... of the rig as its file describes it, all effects included."""
    plant = rig.plant
    assert plant is not None
    assert plant.oil is not None
    assert plant.supply is not None
    assert plant.link is not None
    numbers = {name: 0.0 for name in Machine._fields if name not in ("rotary", "prismatic")}
    for name in ("rotary", "prismatic"):
        numbers |= {f"{name}.{key}": NEUTRAL.get(key, 0.0) for key in Joint._fields} | _joint(plant, name)
    link, oil = plant.link, plant.oil
    numbers |= {
        "hub_offset": rig.arm.hub_offset_m, "hub_inertia": link.hub_inertia_kg_m2, "mass_per_length": link.mass_per_length_kg_per_m,
        "tube_length": link.total_length_m, "carriage": link.carriage_kg, "payload": link.payload_kg, "damping": 0.005,
        "supply": plant.supply.pressure_Pa, "tank": plant.supply.return_pressure_Pa, "line_rate": 500.0, "pump_flow": 6.30902e-4,
        "pump_band": 689475.7, "pump_lag": 0.05, "relief": 15168465.0, "relief_gain": 2e-9, "bulk": oil.bulk_modulus_Pa,
        "bulk_pressure": oil.bulk_modulus_pressure_slope, "vapour": oil.vapour_pressure_Pa - 101325.0,
        "viscosity_a": oil.walther_a, "viscosity_b": oil.walther_b, "bracket_rate": 1.0, "bracket_damping": 0.02, "pulsation_Hz": 9.0,
    }  # fmt: skip
    for entry in plant.effects:
        given = entry.model_dump()
        for parameter, place in EFFECTS[entry.effect].items():
            if parameter in given:
                numbers[place.format(where=entry.where)] = given[parameter]
    return numbers


def _joint(plant: Plant, name: str) -> Numbers:
    joint = plant.joints[name]
    assert isinstance(joint, RotaryActuator | Cylinder)
    valve = joint.valve
    own = {
        "low": joint.travel[0], "high": joint.travel[1], "stop_stiffness": joint.stop_stiffness, "bristle": joint.bristle_stiffness,
        "bristle_damping": joint.bristle_damping, "fade": joint.bristle_fade, "stribeck": joint.bristle_fade,
        "flow": valve.rated_flow_m3_per_s / math.sqrt(valve.rated_pressure_drop_Pa / 2), "full_scale": valve.full_scale_V,
        "slew": 1 / valve.stroke_time_s, "rounding": valve.null_rounding, "laminar": valve.laminar_pressure_Pa,
        "null": valve.null_adjustment,
    }  # fmt: skip
    if isinstance(joint, RotaryActuator):
        own |= {"area_a": joint.displacement_m3_per_rad, "area_b": joint.displacement_m3_per_rad, "volume_at": 0.0}
        own |= {"volume_a": joint.volume_a_m3, "volume_b": joint.volume_b_m3, "drive_stiffness": 1.5e5, "drive_damping": 60.0}
        own |= {"actuator_mass": 2.0}
    else:
        cap, ring = math.pi / 4 * joint.bore_m**2, math.pi / 4 * (joint.bore_m**2 - joint.rod_m**2)
        own |= {"area_a": cap, "area_b": ring, "volume_at": joint.travel[0], "volume_a": joint.dead_volume_a_m3}
        own |= {"volume_b": joint.dead_volume_b_m3 + ring * (joint.travel[1] - joint.travel[0])}
        own |= {"drive_stiffness": 4e6, "drive_damping": 300.0, "actuator_mass": 5.0}
    return {f"{name}.{key}": value for key, value in own.items()}


def error_of(key: str) -> float:
    """Largest relative error of a number."""
    short = key.rpartition(".")[2]
    if short in _EXACT:
        return 0.0
    if key in _ASSUMED or short in _ASSUMED:
        return ASSUMED
    if short in _STATED:
        return 0.002 if short == "viscosity_b" else STATED
    return CATALOGUE if short in _CATALOGUE else FITTED


def jittered(numbers: Mapping[str, float], seed: int) -> Numbers:
    """Every number off by a uniform draw within its error; both chambers of the rotary actuator keep one displacement."""
    draw = np.random.default_rng(seed)
    wrong = {key: value * (1.0 + error_of(key) * draw.uniform(-1, 1)) for key, value in numbers.items()}
    wrong["rotary.area_b"] = wrong["rotary.area_a"]
    return wrong


def machine(numbers: Mapping[str, float]) -> Machine:
    """The integrator's tuples."""
    joints = {name: Joint(**{key: float(numbers[f"{name}.{key}"]) for key in Joint._fields}) for name in ("rotary", "prismatic")}
    whole = {key: float(numbers[key]) for key in Machine._fields if key not in joints}
    return Machine(**joints, **whole)
