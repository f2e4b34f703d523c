"""Whether the simulated rig of a file is the rig that the rest of the file describes."""

from __future__ import annotations

import math
from collections.abc import Iterator

from config.finding import Finding
from config.plant import Plant
from config.rig import Rig
from config.unnamed_remainder import UnnamedRemainder


def check_plant(rig: Rig) -> Iterator[Finding]:
    """Findings about the plant section against signals, joints and link_mode."""
    if rig.plant is None:
        yield Finding("warning", "no plant section: the simulated backend and `longreach gap` cannot use this rig")
        return
    yield from _counts(rig, rig.plant)
    yield from _stops(rig, rig.plant)
    yield from _payload(rig, rig.plant)
    yield from _driving(rig.plant)


def _counts(rig: Rig, plant: Plant) -> Iterator[Finding]:
    """A simulated transducer counts in steps of its resolution, so that is what one count is worth."""
    for name, signal in rig.signals.items():
        if rig.devices[signal.device].driver != "sim":
            continue
        sensor, scale = plant.sensors.get(name), signal.calibration.scale
        if sensor is None:
            yield Finding("error", f"{name} comes from the simulated rig, but plant.sensors has no {name}")
        elif not math.isclose(scale, sensor.resolution, rel_tol=1e-6):
            resolution = f"plant.sensors.{name}.resolution, {sensor.resolution:.6g}"
            yield Finding("error", f"{name}: calibration.scale, {scale:.6g}, is not the simulated count, {resolution}")


def _stops(rig: Rig, plant: Plant) -> Iterator[Finding]:
    for name, joint in rig.joints.items():
        stops = plant.joints[name].travel
        if joint.travel[0] < stops[0] or joint.travel[1] > stops[1]:
            text = f"joints.{name}.travel {_pair(joint.travel)} reaches beyond the stops of the simulated joint, {_pair(stops)}"
            yield Finding("error", text)


def _payload(rig: Rig, plant: Plant) -> Iterator[Finding]:
    if rig.link_mode is None or plant.link is None:
        return
    believed, simulated = rig.link_mode.payload_kg, plant.link.payload_kg
    if not math.isclose(believed, simulated, rel_tol=1e-6, abs_tol=1e-9):
        text = f"link_mode.payload is {believed:.4g} kg, plant.link.payload {simulated:.4g} kg: the shapers are tuned for another arm"
        yield Finding("warning", text)


def _driving(plant: Plant) -> Iterator[Finding]:
    """A table of forces need not take energy, as friction does. It may only take back what friction in the file is too large by."""
    for entry in plant.effects:
        if isinstance(entry, UnnamedRemainder) and entry.drives:
            what = f"unnamed_remainder at {entry.where} pushes along with the motion at some velocity"
            yield Finding("warning", f"{what}: beyond what friction takes there it gives energy, and a simulated joint may never rest")


def _pair(bounds: tuple[float, float]) -> str:
    return f"[{bounds[0]:.6g}, {bounds[1]:.6g}]"
