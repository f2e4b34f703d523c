"""Options of the simulated device, which carries every sensor and every valve of `plant`."""

from __future__ import annotations

from collections.abc import Mapping

from pydantic import Field

from config.options.device_options import Channel, DeviceOptions, RigNames


class SimOptions(DeviceOptions):
    """sim. Inputs: the entries of `plant.sensors` by name, in counts of their resolution. Outputs: JOINT.command in volts."""

    seed: int = Field(default=0, ge=0, strict=True, description="of the simulated sensors' noise, a whole number")

    def input_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        return {sensor: Channel("simulated sensor of this signal") for sensor in rig.sensors}

    def output_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        return {f"{joint}.command": Channel("command to the joint's simulated valve or drive", "V") for joint in rig.joints}
