"""The `options:` of the CANopen drivers, read from a rig file: one class a driver, units as everywhere in the file.

The drivers, the bus budget and the simulated devices read the same classes, so a rig file means the same to all three.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from config.device_options import options_as
from config.rig import Device, Rig
from config.section import Section, quantity

HEARTBEATS_PER_TIMEOUT = 3  # two of ours may be lost before a device calls us dead


class CanBus(Section):
    """The bus a device is on. Devices with the same interface and channel share it and must say the same about it."""

    interface: str = Field(description="python-can interface: socketcan, virtual (one process), udp_multicast (one network namespace), ...")
    channel: str = Field(description="the interface's channel, for example can0")
    bitrate: float = quantity("bit/s", "bit rate of the bus", 1e6, low=1e4, high=1e6)
    load_limit: float = quantity("", "largest part of the bus's time that frames may take, stuffed worst case", 0.7, low=0.01, high=1)
    own_node: int = Field(default=127, ge=1, le=127, description="our node number, under which we send heartbeats")
    fault_cycles: int = Field(default=5, ge=1, description="cycles in a row with a bus fault (no room to send, bus off) that are an error")

    @property
    def key(self) -> tuple[str, str]:
        return self.interface, self.channel


class CanopenOptions(Section):
    """What every CANopen device has."""

    bus: CanBus
    node: int = Field(ge=1, le=127, description="node number of the device")
    heartbeat_s: float = quantity("s", "period of the device's own heartbeat", 0.1, low=0.01, high=10)
    missing_frames: int = Field(default=3, ge=1, description="cycles in a row without the device's frame after which its samples are BAD")


class EncoderOptions(CanopenOptions):
    """canopen_encoder_406. Channels: position, speed, in counts."""

    resolution: int | None = Field(
        default=None, ge=1, description="what object 0x6501 must say: steps a turn, or the linear step in 0.001 um; not compared by default"
    )


class ValveOptions(CanopenOptions):
    """canopen_valve_408. Output: spool, 1 = 100 %. Inputs: spool (16384 = 100 %) and status (the status word)."""

    safe_state: Literal["disabled", "hold"] = Field(
        default="disabled", description="disabled: the hydraulic fail-safe position; hold: the spool is controlled to hold_spool"
    )
    hold_spool: float = quantity("", "spool position in HOLD", 0.0, low=-1, high=1)
    failsafe_spool: float = quantity("", "where the spool stands when the valve is DISABLED", 0.0, low=-1, high=1)
    spool_tolerance: float = quantity("", "the spool is where it should be when it is this near", 0.05, low=0.001, high=0.5)
    control_mode: int = Field(default=2, ge=-128, le=127, description="object 0x6043; 2: closed spool position loop (Moog)")
    fault_reactions: dict[int, int] = Field(
        min_length=1,
        description="object 0x2830, {sub-index: value}: what the valve does when heartbeats or set points fail to come; see the"
        " valve's manual (Moog: sub-index = fault code + 1, value 2 leads to FAULT_DISABLED, 3 to FAULT_HOLD)",
    )
    deadline: bool = Field(default=True, description="the valve supervises the arrival of set points (0x1400:5) for the device's timeout")
    set_point_on_sync: bool = Field(default=False, description="true: a set point acts at the next SYNC; false: at once")
    wrong_state_cycles: int = Field(default=10, ge=1, description="cycles in a row in another state than ACTIVE that are an error")
    proof_spool: float = quantity(
        "", "opening from which the spool must go safe in the proof; 0: only the state is watched", 0.1, low=0, high=1
    )


class IoOptions(CanopenOptions):
    """canopen_io_401. Outputs: output_1 ... in volts. Inputs: input_1 ... in counts."""

    outputs: int = Field(default=4, ge=0, le=4, description="analogue outputs in use, from channel 1")
    inputs: int = Field(default=4, ge=1, le=4, description="analogue inputs in use, from channel 1; their frame is the sign of life")
    every_syncs: int = Field(default=1, ge=1, le=100, description="the inputs are sent at every n-th SYNC")
    counts_per_volt: float = quantity("1/V", "counts of object 0x6411 per volt", 3276.7, low=1, high=1e6)
    proof_voltage_V: float = quantity("V", "voltage from which an output must go to 0 in the proof", 0.5, low=0.1, high=10)
    loopback: dict[int, int] = Field(
        default_factory=dict, description="{output: input wired to it}: the proof then also measures the voltage at the terminals"
    )
    failed_cycles: int = Field(default=10, ge=1, description="cycles in a row without frame or not operational that are an error")


OPTIONS: dict[str, type[CanopenOptions]] = {
    "canopen_encoder_406": EncoderOptions,
    "canopen_valve_408": ValveOptions,
    "canopen_io_401": IoOptions,
}


def canopen_options(name: str, device: Device) -> CanopenOptions:
    """The options of the CANopen device `name`. ConfigError names every option that cannot be used."""
    options = options_as(OPTIONS[device.driver], name, device)
    assert isinstance(options, CanopenOptions)
    return options


def canopen_devices(rig: Rig) -> dict[str, CanopenOptions]:
    """Every CANopen device of the rig with its options. ConfigError as canopen_options()."""
    return {name: canopen_options(name, device) for name, device in rig.devices.items() if device.driver in OPTIONS}


def proofs(rig: Rig) -> dict[str, bool]:
    """Devices whose safe state is proven, and whether arming demands it: CANopen ones with outputs, and whose `demand_proof` is true.

    ConfigError as canopen_options().
    """
    with_outputs = {name for name, options in canopen_devices(rig).items() if _has_outputs(options)}
    return {name: device.demand_proof is not False for name, device in rig.devices.items() if device.demand_proof or (name in with_outputs)}


def our_heartbeat_period_s(rig: Rig, bus: CanBus) -> float:
    """How often we send our heartbeat on `bus`: a third of the shortest time-out of the devices with outputs; 0 when there are none."""
    on_bus = ((name, options) for name, options in canopen_devices(rig).items() if options.bus.key == bus.key)
    timeouts = [rig.devices[name].timeout_s for name, options in on_bus if _has_outputs(options)]
    return min(timeouts, default=0.0) / HEARTBEATS_PER_TIMEOUT


def _has_outputs(options: CanopenOptions) -> bool:
    return isinstance(options, ValveOptions) or (isinstance(options, IoOptions) and options.outputs > 0)
