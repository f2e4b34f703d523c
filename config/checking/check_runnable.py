"""What keeps a rig from being built at all: devices that cannot work as declared, and a simulated device without a plant to simulate."""

from __future__ import annotations

from collections.abc import Iterator

from config.checking.finding import Finding, error_of
from config.loading.cross_checks_devices import declared_devices
from config.parsing.problems import Problem
from config.parsing.yaml_tree import YamlTree
from config.schema.plant import Plant
from config.schema.plant_joint import Crosshead, Cylinder, RotaryActuator
from config.schema.rig import Rig


def check_runnable(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    """An error for every problem, in the order of the file."""
    simulated = [name for name, device in rig.devices.items() if device.driver == "sim"]
    plant = _plant(rig, tree, simulated[0]) if simulated else iter(())
    yield from map(error_of, sorted([*declared_devices(tree).problems, *plant]))


def _plant(rig: Rig, tree: YamlTree, device: str) -> Iterator[Problem]:
    plant = rig.plant
    if plant is None:
        what = f"devices.{device} is the simulated rig, and the file has no section 'plant'"
        yield tree.problem(("devices", device, "driver"), what, next_step="Add plant:, or name the driver of a real device.")
        return
    if rig.arm.kind == "rotary_prismatic" and plant.link is None:
        yield tree.problem(("plant",), "a rotary_prismatic arm needs plant.link", of_key=True, next_step="Add plant.link.")
    for name in plant.joints:
        if f"{name}.position" not in plant.sensors:
            what = f"plant.sensors has no {name}.position: the simulated joint would be blind"
            yield tree.problem(("plant", "sensors"), what, of_key=True, next_step=f"Add plant.sensors.{name}.position.")
    yield from _actuators(rig, plant, tree)
    yield from _chambers(plant, tree)


def _actuators(rig: Rig, plant: Plant, tree: YamlTree) -> Iterator[Problem]:
    for name, joint in plant.joints.items():
        path = ("plant", "joints", name)
        for section in ("oil", "supply"):
            if joint.is_hydraulic and getattr(plant, section) is None:
                what = f"plant.joints.{name} is hydraulic and needs plant.{section}"
                yield tree.problem(path, what, of_key=True, next_step=f"Add plant.{section}.")
        moved = {"mass": joint.mass_kg} if isinstance(joint, Cylinder) else {}
        moved |= {"inertia": joint.inertia_kg_m2} if isinstance(joint, RotaryActuator) else {}
        for key, amount in moved.items():
            if rig.arm.kind == "single_axis" and amount == 0:
                what = f"plant.joints.{name}.{key}: the joint moves none, so any force gives it an endless acceleration"
                yield tree.problem((*path, key), what, value="0", limit="above 0", next_step=f"Write the {key} that moves with the joint.")


def _chambers(plant: Plant, tree: YamlTree) -> Iterator[Problem]:
    """A pressure in a chamber that the simulated joint does not have."""
    for signal in plant.sensors:
        joint, _, measured = signal.rpartition(".")
        actuator = plant.joints.get(joint)
        if actuator is None or measured not in ("pressure_a", "pressure_b") or actuator.is_hydraulic:
            continue
        if isinstance(actuator, Crosshead) and actuator.area_m2 > 0 and measured == "pressure_a":
            continue
        what = f"plant.sensors.{signal}: the joint {joint!r} has no such chamber"
        advice = f"Remove the sensor, or give plant.joints.{joint} an actuator with that chamber (rotary, cylinder)."
        yield tree.problem(
            ("plant", "sensors", signal), what, of_key=True, value=str(tree.value(("plant", "joints", joint, "actuator"))), next_step=advice
        )
