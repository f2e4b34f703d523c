"""Whether the simulated rig of a file is the rig that the rest of the file describes."""

from __future__ import annotations

import math
from collections.abc import Iterator

from config.checking.actuator_sizes import actuator_sizes
from config.checking.finding import Finding, error_at, warning_at
from config.parsing.yaml_tree import YamlTree
from config.schema.effect_library import PROBLEMS
from config.schema.plant import Plant
from config.schema.rig import Rig
from config.schema.section import unit_of


def check_plant(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    """Findings about the plant section against signals, joints and link_mode."""
    if rig.plant is None:
        yield Finding("warning", "no plant section: the simulated backend and `longreach gap` cannot use this rig")
        return
    yield from _counts(rig, rig.plant, tree)
    yield from _stops(rig, rig.plant, tree)
    yield from _payload(rig, rig.plant, tree)
    yield from _effects(rig.plant, tree)
    yield from _held(rig, rig.plant, tree)


def _counts(rig: Rig, plant: Plant, tree: YamlTree) -> Iterator[Finding]:
    """A simulated transducer counts in steps of its resolution, so that is what one count is worth."""
    for name, signal in rig.signals.items():
        if rig.devices[signal.device].driver != "sim":
            continue
        sensor, scale = plant.sensors.get(signal.channel), signal.calibration.scale
        if sensor is not None and not math.isclose(scale, sensor.resolution, rel_tol=1e-6):
            unit = unit_of(type(signal.calibration).model_fields["scale"])
            resolution = f"plant.sensors.{signal.channel}.resolution, {sensor.resolution:.6g} {unit}"
            text = f"{name}: calibration.scale, {scale:.6g} {unit}, is not the simulated count, {resolution}"
            yield error_at(tree, ("signals", name, "calibration", "scale"), text)


def _stops(rig: Rig, plant: Plant, tree: YamlTree) -> Iterator[Finding]:
    for name, joint in rig.joints.items():
        stops = plant.joints[name].travel
        if joint.travel[0] < stops[0] or joint.travel[1] > stops[1]:
            unit = joint.position_unit
            own, most = (f"{low:.6g} to {high:.6g} {unit}" for low, high in (joint.travel, stops))
            text = f"joints.{name}.travel {own} reaches beyond the stops of the simulated joint, {most}"
            yield error_at(tree, ("joints", name, "travel"), text)


def _payload(rig: Rig, plant: Plant, tree: YamlTree) -> Iterator[Finding]:
    if rig.link_mode is None or plant.link is None:
        return
    believed, simulated = rig.link_mode.payload_kg, plant.link.payload_kg
    if not math.isclose(believed, simulated, rel_tol=1e-6, abs_tol=1e-9):
        text = f"link_mode.payload is {believed:.4g} kg, plant.link.payload {simulated:.4g} kg: the shapers are tuned for another arm"
        yield warning_at(tree, ("link_mode", "payload"), text)


def _effects(plant: Plant, tree: YamlTree) -> Iterator[Finding]:
    yield from (Finding("warning", text) for text in PROBLEMS)
    for number, entry in enumerate(plant.effects):
        yield from (warning_at(tree, ("plant", "effects", number), text) for text in entry.warnings())


def _held(rig: Rig, plant: Plant, tree: YamlTree) -> Iterator[Finding]:
    """A joint that friction holds against all that its actuator can do."""
    for number, entry in enumerate(plant.effects):
        friction = getattr(entry, "friction", 0.0) if entry.effect == "coulomb_friction" else 0.0
        sizes = actuator_sizes(rig, entry.where) if friction > 0.0 else None
        if sizes is None:
            continue
        most, unit = sizes.drop_Pa * max(sizes.areas), "N*m" if sizes.unit == "rad" else "N"
        if friction >= most:
            text = f"coulomb_friction of {friction:.4g} {unit} holds {entry.where}: supply pressure gives {most:.4g} {unit} at most"
            yield warning_at(tree, ("plant", "effects", number, "friction"), text)
