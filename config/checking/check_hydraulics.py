"""Sizes of the simulated hydraulics against each other: valve against bore and stroke, mass against force, oil against any oil."""

from __future__ import annotations

import math
from collections.abc import Iterator

from config.checking.actuator_sizes import ActuatorSizes, actuator_sizes
from config.checking.finding import Finding, warning_at
from config.parsing.yaml_tree import YamlTree
from config.schema.model_fields import limits
from config.schema.plant import Oil
from config.schema.plant_joint import Cylinder, RotaryActuator
from config.schema.rig import Loop, Rig

FASTEST_CROSSING_S = 0.1
CYCLES_A_PERIOD = 10
BULK_MODULUS_PA = (3e8, 3e9)
VISCOSITY_CST = (2.0, 3000.0)
DENSITY_KG_PER_M3 = (750.0, 1250.0)
DEAD_SHARE = 20.0  # of the swept volume


def check_hydraulics(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    """Findings about actuators, valves and oil of `plant`."""
    if rig.plant is None:
        return
    for name in rig.joints:
        sizes = actuator_sizes(rig, name)
        if sizes is not None:
            yield from _speed(rig, tree, name, sizes)
            yield from _acceleration(rig, tree, name, sizes)
            yield from _frequency(rig, tree, name, sizes)
            yield from _volumes(rig, tree, name, sizes)
    if rig.plant.oil is not None:
        yield from _oil(rig.plant.oil, tree)


def _speed(rig: Rig, tree: YamlTree, name: str, sizes: ActuatorSizes) -> Iterator[Finding]:
    path = ("plant", "joints", name, "valve", "rated_flow")
    flow = f"plant.joints.{name}: the open valve gives {6e4 * sizes.full_flow_m3_per_s:.3g} l/min at {1e-6 * sizes.drop_Pa:.3g} MPa"
    speed = f"{sizes.full_speed:.3g} {sizes.unit}/s on {1e4 * max(sizes.areas):.3g} cm^2"
    if sizes.unit == "rad":
        speed = f"{sizes.full_speed:.3g} rad/s on {1e6 * max(sizes.areas):.3g} cm^3/rad"
    crossing_s = sizes.stroke / sizes.full_speed if sizes.full_speed > 0 else math.inf
    if crossing_s < FASTEST_CROSSING_S:
        text = f"{flow}, {speed}: through the whole stroke in {1e3 * crossing_s:.0f} ms"
        yield warning_at(tree, path, f"{text}. Compare rated_flow, rated_pressure_drop and bore with the data sheets.")
    if sizes.full_speed < rig.joints[name].rate_limit:
        limit = f"joints.{name}.rate_limit is {rig.joints[name].rate_limit:.3g} {sizes.unit}/s"
        yield warning_at(tree, path, f"{flow}, {speed}; {limit}: the joint cannot reach it")


def _acceleration(rig: Rig, tree: YamlTree, name: str, sizes: ActuatorSizes) -> Iterator[Finding]:
    limit = rig.joints[name].acceleration_limit
    if sizes.largest_acceleration < limit:
        mass = f"{sizes.mass:.3g} kg" if sizes.unit == "m" else f"{sizes.mass:.3g} kg m^2"
        can = f"supply pressure on the piston gives {mass} at most {sizes.largest_acceleration:.3g} {sizes.unit}/s^2"
        text = f"joints.{name}.acceleration_limit is {limit:.3g} {sizes.unit}/s^2, but {can}"
        yield warning_at(tree, ("joints", name, "acceleration_limit"), text)


def _frequency(rig: Rig, tree: YamlTree, name: str, sizes: ActuatorSizes) -> Iterator[Finding]:
    frequency_Hz = sizes.natural_frequency_Hz
    if frequency_Hz > rig.loop.rate_Hz / CYCLES_A_PERIOD:
        cycles = rig.loop.rate_Hz / frequency_Hz
        text = f"plant.joints.{name}: mass and oil ring at {frequency_Hz:.3g} Hz; the loop at {rig.loop.rate_Hz:g} Hz has"
        text = f"{text} {cycles:.1f} cycles a period, fewer than {CYCLES_A_PERIOD}"
        yield warning_at(tree, ("plant", "joints", name), f"{text}: {_enough(CYCLES_A_PERIOD * frequency_Hz)}")


def _enough(rate_Hz: float) -> str:
    """Which rate would do, or what to do where none does."""
    highest_Hz = limits(Loop.model_fields["rate_Hz"])[1] or math.inf
    if rate_Hz > highest_Hz:
        return f"no loop.rate up to {highest_Hz:g} Hz has them, the servo can't damp this resonance: keep its gain low"
    return f"loop.rate from {10 * math.ceil(rate_Hz / 10)} Hz has them; below that keep the gain low"


def _volumes(rig: Rig, tree: YamlTree, name: str, sizes: ActuatorSizes) -> Iterator[Finding]:
    joint = rig.plant.joints[name] if rig.plant else None
    if isinstance(joint, RotaryActuator):
        yield from _swept_beyond(tree, name, joint)
        return
    assert isinstance(joint, Cylinder)
    dead_volumes = {"dead_volume_a": joint.dead_volume_a_m3, "dead_volume_b": joint.dead_volume_b_m3}
    for (key, dead), area in zip(dead_volumes.items(), sizes.areas, strict=True):
        if dead > DEAD_SHARE * area * sizes.stroke:
            text = f"plant.joints.{name}.{key} is {1e6 * dead:.4g} cm^3, {dead / (area * sizes.stroke):.3g} times what the piston sweeps"
            yield warning_at(tree, ("plant", "joints", name, key), f"{text}: the oil in it is a spring")


def _swept_beyond(tree: YamlTree, name: str, joint: RotaryActuator) -> Iterator[Finding]:
    """Volumes are those at position 0; at the far stop nothing may be left of one."""
    for key, volume, side in (("volume_a", joint.volume_a_m3, -joint.travel[0]), ("volume_b", joint.volume_b_m3, joint.travel[1])):
        swept = joint.displacement_m3_per_rad * side
        if swept >= volume:
            text = f"plant.joints.{name}.{key} is {1e6 * volume:.4g} cm^3 at position 0, and {1e6 * swept:.4g} cm^3 are swept out of it"
            yield warning_at(tree, ("plant", "joints", name, key), f"{text} up to the stop: the chamber is empty before")


def _oil(oil: Oil, tree: YamlTree) -> Iterator[Finding]:
    kelvin = oil.initial_temperature_C + 273.15
    loglog = oil.walther_a - oil.walther_b * math.log10(kelvin)
    viscosity_cSt = 10 ** min(10 ** min(loglog, 3.0), 300.0) - 0.7
    looked_at = (
        ("walther_b", "viscosity", viscosity_cSt, VISCOSITY_CST, f"cSt at {oil.initial_temperature_C:g} degC by walther_a and walther_b"),
        ("bulk_modulus", "bulk_modulus", 1e-9 * oil.bulk_modulus_Pa, tuple(1e-9 * end for end in BULK_MODULUS_PA), "GPa"),
        ("density", "density", oil.density_kg_per_m3, DENSITY_KG_PER_M3, "kg/m^3"),
    )
    for key, word, value, (low, high), unit in looked_at:
        if not low <= value <= high:
            text = f"plant.oil: {word} is {value:.3g} {unit}; hydraulic fluids have {low:g} to {high:g}"
            yield warning_at(tree, ("plant", "oil", key), text)
