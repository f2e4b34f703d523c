"""What a rig's CANopen devices mean together: which there are, whose safe state is proven, how often we must say that we live."""

from __future__ import annotations

from config.options.canopen_options import CanBus, CanopenOptions
from config.options.device_options import DeviceOptions
from config.options.driver_options import rig_options
from config.options.plug_in_code import working
from config.schema.rig import Rig

HEARTBEATS_PER_TIMEOUT = 3  # two of ours may be lost before a device calls us dead


def canopen_devices(rig: Rig) -> dict[str, CanopenOptions]:
    """Every CANopen device of the rig with its options. ConfigError as driver_options.device_options()."""
    return {name: options for name, options in rig_options(rig).items() if isinstance(options, CanopenOptions)}


def proofs(rig: Rig) -> dict[str, bool]:
    """Devices whose safe state is proven, and whether arming demands it: those whose driver declares it, and whose `demand_proof` is true.

    ConfigError as driver_options.device_options().
    """
    declared = {name for name, options in rig_options(rig).items() if _must_prove(rig.devices[name].driver, options)}
    return {name: device.demand_proof is not False for name, device in rig.devices.items() if device.demand_proof or name in declared}


def _must_prove(driver: str, options: DeviceOptions) -> bool:
    with working(driver, "must_prove()"):
        return options.must_prove()


def our_heartbeat_period_s(rig: Rig, bus: CanBus) -> float:
    """How often we send our heartbeat on `bus`: a third of the shortest time-out of the devices with outputs; 0 when there are none."""
    on_bus = ((name, options) for name, options in canopen_devices(rig).items() if options.bus.key == bus.key)
    timeouts = [rig.devices[name].timeout_s for name, options in on_bus if options.must_prove()]
    return min(timeouts, default=0.0) / HEARTBEATS_PER_TIMEOUT
