"""The `options:` of the CANopen drivers, read from a rig file: one class a driver, units as everywhere in the file.

The drivers, the bus budget and the simulated devices read the same classes, so a rig file means the same to all three.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal, NamedTuple

from pydantic import Field, field_validator, model_validator

from config.options.device_options import Address, Channel, DeviceOptions, RigNames
from config.parsing.nearest import nearest_text
from config.schema.section import Section, quantity

_I16_LOW, _I16_HIGH = -32768.0, 32767.0


class CanBus(Section):
    """The bus a device is on. Devices with the same interface and channel share it and must say the same about it."""

    interface: str = Field(description="python-can interface: socketcan, virtual (one process), udp_multicast (one network namespace), ...")
    channel: str = Field(description="the interface's channel, for example can0")
    bitrate: float = quantity("bit/s", "bit rate of the bus", 1e6, low=1e4, high=1e6)
    load_limit: float = quantity("", "largest part of the bus's time that frames may take, stuffed worst case", 0.7, low=0.01, high=1)
    own_node: int = Field(default=127, ge=1, le=127, description="our node number, under which we send heartbeats")
    fault_cycles: int = Field(default=5, ge=1, description="cycles in a row with a bus fault (no room to send, bus off) that are an error")

    @field_validator("interface")
    @classmethod
    def _is_known(cls, interface: str) -> str:
        from can.interfaces import VALID_INTERFACES  # 0.1 s, which only a rig with CAN pays

        if interface not in VALID_INTERFACES:
            raise ValueError(f"python-can has no such interface{nearest_text(interface, sorted(VALID_INTERFACES))}")
        return interface

    @property
    def key(self) -> tuple[str, str]:
        return self.interface, self.channel

    @property
    def link(self) -> tuple[str, ...]:
        """As in Address."""
        return ("CAN", *self.key)


class ProcessData(NamedTuple):
    """A frame of process data: its name in CiA 301, its bytes, and at every how many SYNCs it comes."""

    name: str
    data_bytes: int
    syncs: int = 1


class CanopenOptions(DeviceOptions):
    """What every CANopen device has."""

    served_by: ClassVar[Literal["loop", "I/O process", "either"]] = "loop"

    bus: CanBus
    node: int = Field(ge=1, le=127, description="node number of the device")
    heartbeat_s: float = quantity("s", "period of the device's own heartbeat", 0.1, low=0.01, high=10)
    missing_frames: int = Field(default=3, ge=1, description="cycles in a row without the device's frame after which its samples are BAD")

    def address(self) -> Address:
        agreed = {f"bus.{option}": value for option, value in self.bus}
        return Address(self.bus.link, self.node, "node", agreed, {self.bus.own_node: "our own number, bus.own_node"})

    def process_data(self) -> tuple[ProcessData, ...]:
        """For subclasses: the frames of the bus budget, besides SYNC and heartbeats."""
        return ()


class EncoderOptions(CanopenOptions):
    """canopen_encoder_406. Channels: position, speed, in counts."""

    resolution: int | None = Field(
        default=None,
        ge=1,
        le=2**32 - 1,
        description="what object 0x6501 must say: steps a turn, or the linear step in 0.001 um; not compared by default",
    )

    def input_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        return {
            "position": Channel("object 0x6004", low=0.0, high=2.0**32 - 1, mapped=0x60040020),
            "speed": Channel("object 0x6030, sub-index 1", low=_I16_LOW, high=_I16_HIGH, mapped=0x60300110),
        }

    def process_data(self) -> tuple[ProcessData, ...]:
        return (ProcessData("TPDO1", 8),)


class ValveOptions(CanopenOptions):
    """canopen_valve_408. Output: spool, 1 = 100 %. Inputs: spool (16384 = 100 %) and status (the status word)."""

    proves_safe_state: ClassVar[bool] = True

    safe_state: Literal["disabled", "hold"] = Field(
        default="disabled", description="disabled: the hydraulic fail-safe position; hold: the spool is controlled to hold_spool"
    )
    hold_spool: float = quantity("", "spool position in HOLD", 0.0, low=-1, high=1)
    failsafe_spool: float = quantity("", "where the spool stands when the valve is DISABLED", 0.0, low=-1, high=1)
    spool_tolerance: float = quantity("", "the spool is where it should be when it is this near", 0.05, low=0.001, high=0.5)
    control_mode: int = Field(default=2, ge=-128, le=127, description="object 0x6043; 2: closed spool position loop (Moog)")
    fault_reactions: dict[Annotated[int, Field(ge=1, le=254)], Annotated[int, Field(ge=0, le=255)]] = Field(
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

    @model_validator(mode="after")
    def _is_shut_where_it_is_safe(self) -> ValveOptions:
        """The driver takes every valve through DISABLED and HOLD, and a fault leads to one of them: neither may move the arm."""
        for key, spool in (("hold_spool", self.hold_spool), ("failsafe_spool", self.failsafe_spool)):
            if abs(spool) > self.spool_tolerance:
                limit = f"a safe spool stands within spool_tolerance, {self.spool_tolerance:g}, of its middle"
                raise ValueError(f"{key} is {spool:g}, and {limit}: an open valve moves the arm")
        return self

    def input_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        return {
            "spool": Channel("object 0x6301, 16384 = 100 %", low=_I16_LOW, high=_I16_HIGH, mapped=0x63010110),
            "status": Channel("object 0x6041, the status word", "", 0.0, 65535.0, mapped=0x60410010),
        }

    def output_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        return {"spool": Channel("object 0x6300, 1 = 100 %", "", -1.0, 1.0, mapped=0x63000110)}

    def process_data(self) -> tuple[ProcessData, ...]:
        return ProcessData("RPDO1", 4), ProcessData("TPDO1", 4)

    def warnings(self) -> Iterator[tuple[str, str]]:
        if self.proof_spool and self.proof_spool <= self.spool_tolerance:
            what = f"the proof opens the spool by {self.proof_spool:g}, no more than spool_tolerance, {self.spool_tolerance:g}"
            yield "proof_spool", f"{what}: it can't see the spool go safe"


class IoOptions(CanopenOptions):
    """canopen_io_401. Outputs: output_1 ... in volts. Inputs: input_1 ... in counts."""

    proves_safe_state: ClassVar[bool] = True

    outputs: int = Field(default=4, ge=0, le=4, description="analogue outputs in use, from channel 1")
    inputs: int = Field(default=4, ge=1, le=4, description="analogue inputs in use, from channel 1; their frame is the sign of life")
    every_syncs: int = Field(default=1, ge=1, le=100, description="the inputs are sent at every n-th SYNC")
    counts_per_volt: float = quantity("1/V", "counts of object 0x6411 per volt", 3276.7, low=1, high=1e6)
    proof_voltage_V: float = quantity("V", "voltage from which an output must go to 0 in the proof", 0.5, low=0.1, high=10)
    loopback: dict[int, int] = Field(
        default_factory=dict, description="{output: input wired to it}: the proof then also measures the voltage at the terminals"
    )
    failed_cycles: int = Field(default=10, ge=1, description="cycles in a row without frame or not operational that are an error")

    @model_validator(mode="after")
    def _proof_is_a_count(self) -> IoOptions:
        counts = self.proof_voltage_V * self.counts_per_volt
        if self.outputs and counts > _I16_HIGH:
            shown = f"proof_voltage, {self.proof_voltage_V:g} V, at {self.counts_per_volt:g} counts per volt is {counts:g} counts"
            raise ValueError(f"{shown}, and the outputs end at {_I16_HIGH:g}")
        return self

    @model_validator(mode="after")
    def _wires_end_at_channels(self) -> IoOptions:
        for output, wired_to in self.loopback.items():
            if not 1 <= output <= self.outputs or not 1 <= wired_to <= self.inputs:
                wire, have = f"loopback {{{output}: {wired_to}}}", f"outputs 1 to {self.outputs} and inputs 1 to {self.inputs} are in use"
                raise ValueError(f"{wire} is {{output: input}}, and {have}")
        return self

    def input_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        return {
            f"input_{number}": Channel(
                "object 0x6401, as the module scales it", low=_I16_LOW, high=_I16_HIGH, mapped=0x64010010 | number << 8
            )
            for number in range(1, self.inputs + 1)
        }

    def output_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        largest_V = _I16_HIGH / self.counts_per_volt
        return {
            f"output_{number}": Channel("object 0x6411", "V", -largest_V, largest_V, mapped=0x64110010 | number << 8)
            for number in range(1, self.outputs + 1)
        }

    def process_data(self) -> tuple[ProcessData, ...]:
        told = (ProcessData("RPDO2", 2 * self.outputs),) if self.outputs else ()
        return *told, ProcessData("TPDO2", 2 * self.inputs, self.every_syncs)
