"""The same rig with the simulated rig in the place of its devices: what runs in lockstep, where no bus can be.

A signal keeps its name, range and age; its counts become those of the simulated transducer. A volt of a joint's command stays a volt.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import takewhile

from config.errors import ConfigError
from config.loading.load import LoadedRig, apply_overrides, rig_from_text
from config.schema.plant import Plant
from config.schema.rig import Rig
from config.schema.section import unit_of

SIMULATED = "simulated_rig"


def with_simulated_devices(loaded: LoadedRig) -> LoadedRig:
    """Unchanged where every device is simulated already. ConfigError when the plant lacks what a device measures."""
    rig = loaded.rig
    if all(device.driver == "sim" for device in rig.devices.values()):
        return loaded
    if rig.plant is None:
        advice = "Add the section plant: to the rig file, or run it on its devices with longreachd."
        raise ConfigError("there is nothing to simulate in the place of the devices", where=loaded.path, next_step=advice)
    devices = f"devices={{{SIMULATED}: {{driver: sim}}}}"
    text = loaded.text
    for assignment in (devices, *_signals(rig, rig.plant, loaded.path), *_outputs(rig)):
        text = _line_for_line(text, apply_overrides(text, [assignment]))
    return LoadedRig(rig_from_text(text, loaded.path), text, loaded.path)


def _line_for_line(before: str, after: str) -> str:
    """`after`, with empty lines for those that it lacks where it was changed: messages name lines of the file that the user has."""
    same_end = sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(reversed(before), reversed(after), strict=False)))
    at = after.find("\n", len(after) - same_end)
    return after[:at] + "\n" * (before.count("\n") - after.count("\n")) + after[at:] if at >= 0 else after


def _signals(rig: Rig, plant: Plant, where: str) -> Iterator[str]:
    for name, signal in rig.signals.items():
        sensor = plant.sensors.get(name)
        if sensor is None:
            what = f"the plant has no sensor {name}, which {signal.device} measures"
            raise ConfigError(what, where=where, next_step=f"Add plant.sensors.{name}, or remove the signal.")
        unit = unit_of(type(signal.calibration).model_fields["scale"]) or ""
        yield f"signals.{name}.device={SIMULATED}"
        yield f"signals.{name}.channel={name}"
        yield f"signals.{name}.calibration={{scale: {sensor.resolution!r} {unit}}}"


def _outputs(rig: Rig) -> Iterator[str]:
    for joint in rig.joints:
        yield f"outputs.{joint}={{device: {SIMULATED}, channel: {joint}.command}}"
