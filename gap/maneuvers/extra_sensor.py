"""Sensors a rig does not have but could: with what noise, and the plant with them fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from config.loading.load import load_rig
from config.schema.plant import Plant
from config.schema.plant_sensor import Sensor
from config.schema.rig import Rig
from config.signal_names import SECOND_POSITION, signal_measures
from gap.fitting.model import Model

_TYPICAL = "ornl_testbed"  # whose sensors of the same kind say what a sensor not fitted would be like


@dataclass(frozen=True, slots=True)
class ExtraSensor:
    """Channels that would be fitted together."""

    channels: tuple[str, ...]

    @property
    def text(self) -> str:
        """For a reader: what to fit."""
        joint, _, quantity = self.channels[0].partition(".")
        if quantity == SECOND_POSITION:
            return f"a second position sensor of {joint}, read on its own"
        return " and ".join(self.channels)


def extra_sensors(rig: Rig, measured: Sequence[str]) -> list[ExtraSensor]:
    """What could be measured beside `measured`: chamber pressures of every hydraulic joint, the ports' pressures, the tip's motion, and
    every joint's position once more."""
    assert rig.plant is not None
    groups: list[tuple[str, ...]] = []
    for name, joint in rig.plant.joints.items():
        if joint.is_hydraulic:
            groups += [(f"{name}.pressure_a", f"{name}.pressure_b"), (f"{name}.supply_pressure", f"{name}.return_pressure")]
    if rig.arm.kind == "rotary_prismatic":
        groups += [("tip.deflection",), ("tip.acceleration",)]
    groups += [(f"{name}.{SECOND_POSITION}",) for name, joint in rig.plant.joints.items() if not joint.is_imposed]
    absent = [tuple(channel for channel in group if channel not in measured) for group in groups]
    return [ExtraSensor(channels) for channels in absent if channels]


def with_sensors(model: Model, extras: Sequence[ExtraSensor]) -> Model:
    """The model on the rig with these sensors beside its own."""
    plant = model.rig.plant
    assert plant is not None
    kinds = _kinds(plant)
    wanted = [channel for extra in extras for channel in extra.channels if channel not in plant.sensors]
    added = {channel: _like(plant.sensors, kinds[channel], kinds) for channel in wanted}
    changed = plant.model_copy(update={"sensors": plant.sensors | added})
    return replace(model, rig=model.rig.model_copy(update={"plant": changed}))


def _kinds(plant: Plant) -> dict[str, str]:
    return signal_measures({name: joint.motion for name, joint in plant.joints.items()})


def _like(sensors: dict[str, Sensor], kind: str, kinds: dict[str, str]) -> Sensor:
    """A sensor as the rig has one of this kind, else as the typical rig has."""
    own = next((sensor for name, sensor in sensors.items() if kinds[name] == kind), None)
    if own is not None:
        return own
    typical = load_rig(_TYPICAL).rig.plant
    assert typical is not None
    named = _kinds(typical)
    return next(sensor for name, sensor in typical.sensors.items() if named[name] == kind)
