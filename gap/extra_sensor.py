"""Sensors a rig does not have but could: with what noise, and the plant with them fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from config.load import load_rig
from config.plant_sensor import Sensor
from config.rig import Rig
from config.signals import signal_measures
from gap.model import Model

_TYPICAL = "ornl_testbed"  # whose sensors of the same kind say what a sensor not fitted would be like


@dataclass(frozen=True, slots=True)
class ExtraSensor:
    """Channels that would be fitted together."""

    channels: tuple[str, ...]


def extra_sensors(rig: Rig, measured: Sequence[str]) -> list[ExtraSensor]:
    """What could be measured beside `measured`: chamber pressures of every hydraulic joint, the ports' pressures, the tip's motion."""
    assert rig.plant is not None
    groups: list[tuple[str, ...]] = []
    for name, joint in rig.plant.joints.items():
        if joint.is_hydraulic:
            groups += [(f"{name}.pressure_a", f"{name}.pressure_b"), (f"{name}.supply_pressure", f"{name}.return_pressure")]
    if rig.arm.kind == "rotary_prismatic":
        groups += [("tip.deflection",), ("tip.acceleration",)]
    absent = [tuple(channel for channel in group if channel not in measured) for group in groups]
    return [ExtraSensor(channels) for channels in absent if channels]


def with_sensors(model: Model, extras: Sequence[ExtraSensor]) -> Model:
    """The model on the rig with these sensors beside its own."""
    plant = model.rig.plant
    assert plant is not None
    kinds = signal_measures({name: joint.motion for name, joint in plant.joints.items()})
    added = {
        channel: _like(plant.sensors, kinds[channel], kinds)
        for extra in extras
        for channel in extra.channels
        if channel not in plant.sensors
    }
    changed = plant.model_copy(update={"sensors": {**plant.sensors, **added}})
    return replace(model, rig=model.rig.model_copy(update={"plant": changed}))


def _like(sensors: dict[str, Sensor], kind: str, kinds: dict[str, str]) -> Sensor:
    """A sensor as the rig has one of this kind, else as the typical rig has."""
    own = next((sensor for name, sensor in sensors.items() if kinds[name] == kind), None)
    if own is not None:
        return own
    typical = load_rig(_TYPICAL).rig.plant
    assert typical is not None
    named = signal_measures({name: joint.motion for name, joint in typical.joints.items()})
    return next(sensor for name, sensor in typical.sensors.items() if named[name] == kind)
