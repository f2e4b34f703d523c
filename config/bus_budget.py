"""How much of a CAN bus's time a rig needs in the worst case, and whether that is allowed.

A data frame with an 11-bit identifier and n bytes has 47 + 8 n bits (with the 3 bits between frames); 34 + 8 n of them, from start
of frame to the end of the CRC, are subject to stuffing, which adds at most one bit after the first five and then one every four:
floor((34 + 8 n - 1) / 4). So 55 bits for n = 0, 95 for 4, 135 for 8 (Davis, Burns, Bril, Lukkien, Real-Time Systems 35, 2007).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from config.canopen_options import CanBus, CanopenOptions, EncoderOptions, IoOptions, ValveOptions, canopen_devices, our_heartbeat_period_s
from config.errors import ConfigError
from config.finding import Finding
from config.rig import Rig


def worst_case_bits(data_bytes: int) -> int:
    """Bits of a data frame with 11-bit identifier, all possible stuff bits and the gap to the next frame."""
    return 47 + 8 * data_bytes + (34 + 8 * data_bytes - 1) // 4


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame that comes again and again. `per_second` of a frame of every cycle is the rate of the loop."""

    name: str
    data_bytes: int
    per_second: float

    @property
    def bits(self) -> int:
        return worst_case_bits(self.data_bytes)


@dataclass(frozen=True, slots=True)
class BusLoad:
    """The load of one bus: `cyclic` frames come once a cycle, `others` (heartbeats, slower process data) at their own rates."""

    bus: CanBus
    rate_Hz: float
    cyclic: tuple[Frame, ...]
    others: tuple[Frame, ...]

    @property
    def load(self) -> float:
        """Part of the bus's time that is taken, worst case; 1 is a full bus."""
        return sum(frame.bits * frame.per_second for frame in (*self.cyclic, *self.others)) / self.bus.bitrate

    def text(self) -> str:
        """'can0: 7 frames/cycle at 1000 Hz = 71 % of 1 Mbit/s, limit 70 %: SYNC 55 bits, ...'"""
        named = ", ".join(f"{frame.name} {frame.bits} bits" for frame in self.cyclic)
        rarer = ", ".join(f"{frame.name} {frame.bits} bits at {frame.per_second:g} Hz" for frame in self.others)
        return (
            f"{self.bus.channel}: {len(self.cyclic)} frames/cycle at {self.rate_Hz:g} Hz = {100 * self.load:.1f} % of"
            f" {self.bus.bitrate / 1e6:g} Mbit/s, limit {100 * self.bus.load_limit:g} %: {named}; besides {rarer}"
        )


def bus_loads(rig: Rig) -> list[BusLoad]:
    """The load of every CAN bus of the rig. ConfigError when a device's options cannot be used or contradict another's."""
    devices = canopen_devices(rig)
    buses: dict[tuple[str, str], CanBus] = {}
    for name, options in devices.items():
        if options.bus != buses.setdefault(options.bus.key, options.bus):
            where = f"devices.{name}.options.bus"
            raise ConfigError(f"says something else about bus {options.bus.channel} than a device before it", where=where)
    _refuse_shared_nodes(devices)
    return [_load(rig, bus, {name: options for name, options in devices.items() if options.bus.key == key}) for key, bus in buses.items()]


def check_bus_budget(rig: Rig) -> Iterator[Finding]:
    """One finding a bus: an error when its load is above its limit."""
    try:
        loads = bus_loads(rig)
    except ConfigError as error:
        yield Finding("error", str(error))
        return
    for load in loads:
        if load.load <= load.bus.load_limit:
            yield Finding("ok", load.text())
            continue
        highest_Hz = int(load.rate_Hz * load.bus.load_limit / load.load)
        yield Finding("error", f"{load.text()}. Lower loop.rate to {highest_Hz} Hz, or use a second bus or a higher bit rate.")


def _refuse_shared_nodes(devices: dict[str, CanopenOptions]) -> None:
    taken: dict[tuple[tuple[str, str], int], str] = {}
    for name, options in devices.items():
        where = f"devices.{name}.options.node"
        if options.node == options.bus.own_node:
            raise ConfigError("this node number is our own", value=options.node, where=where, next_step="Change it, or bus.own_node.")
        first = taken.setdefault((options.bus.key, options.node), name)
        if first != name:
            raise ConfigError(f"device {first!r} on the same bus has this node number", value=options.node, where=where)


def _load(rig: Rig, bus: CanBus, devices: dict[str, CanopenOptions]) -> BusLoad:
    rate_Hz = rig.loop.rate_Hz
    cyclic = [Frame("SYNC", 0, rate_Hz)]
    others = [Frame(f"{name} heartbeat", 1, 1 / options.heartbeat_s) for name, options in devices.items()]
    for name, options in devices.items():
        for pdo, size, syncs in _pdos(options):
            if syncs == 1:
                cyclic.append(Frame(f"{name} {pdo}", size, rate_Hz))
            else:
                others.append(Frame(f"{name} {pdo} every {syncs} cycles", size, rate_Hz / syncs))
    period_s = our_heartbeat_period_s(rig, bus)
    if period_s:
        others.append(Frame("our heartbeat", 1, 1 / period_s))
    return BusLoad(bus, rate_Hz, tuple(cyclic), tuple(others))


def _pdos(options: CanopenOptions) -> list[tuple[str, int, int]]:
    """(name, bytes, cycles between two) of the process data frames of one device."""
    if isinstance(options, EncoderOptions):
        return [("TPDO1", 8, 1)]
    if isinstance(options, ValveOptions):
        return [("RPDO1", 4, 1), ("TPDO1", 4, 1)]
    if isinstance(options, IoOptions):
        told = [("RPDO2", 2 * options.outputs, 1)] if options.outputs else []
        return [*told, ("TPDO2", 2 * options.inputs, options.every_syncs)]
    raise ConfigError("no frames are known for this device", value=type(options).__name__)
