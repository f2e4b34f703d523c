"""How much of a CAN bus's time a rig needs in the worst case, and whether that is allowed.

A data frame with an 11-bit identifier and n bytes has 47 + 8 n bits (with the 3 bits between frames); 34 + 8 n of them, from start
of frame to the end of the CRC, are subject to stuffing, which adds at most one bit after the first five and then one every four:
floor((34 + 8 n - 1) / 4). So 55 bits for n = 0, 95 for 4, 135 for 8 (Davis, Burns, Bril, Lukkien, Real-Time Systems 35, 2007).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from config.checking.finding import Finding, error_of
from config.errors import ConfigError
from config.options.canopen_options import CanBus, CanopenOptions
from config.options.canopen_rig import canopen_devices, our_heartbeat_period_s
from config.parsing.yaml_tree import YamlTree
from config.schema.rig import Rig


def worst_case_bits(data_bytes: int) -> int:
    """Bits of a data frame with 11-bit identifier, all possible stuff bits and the gap to the next frame."""
    return 47 + 8 * data_bytes + (34 + 8 * data_bytes - 1) // 4


@dataclass(frozen=True, slots=True)
class RepeatedFrame:
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
    cyclic: tuple[RepeatedFrame, ...]
    others: tuple[RepeatedFrame, ...]

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
    """The load of every CAN bus of the rig. ConfigError when a device's options cannot be used."""
    devices = canopen_devices(rig)
    buses = {options.bus.key: options.bus for options in devices.values()}
    return [_load(rig, bus, {name: options for name, options in devices.items() if options.bus.key == key}) for key, bus in buses.items()]


def check_bus_budget(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    """One finding a bus: an error, at the bus of its first device, when its load is above its limit."""
    try:
        loads = bus_loads(rig)
    except ConfigError:
        return  # check_devices names what cannot be used
    for load in loads:
        if load.load <= load.bus.load_limit:
            yield Finding("ok", load.text())
            continue
        highest_Hz = int(load.rate_Hz * load.bus.load_limit / load.load)
        first = next(name for name, options in canopen_devices(rig).items() if options.bus.key == load.bus.key)
        advice = f"Lower loop.rate to {highest_Hz} Hz, or use a second bus or a higher bit rate."
        yield error_of(tree.problem(("devices", first, "options", "bus"), load.text(), next_step=advice))


def _load(rig: Rig, bus: CanBus, devices: dict[str, CanopenOptions]) -> BusLoad:
    rate_Hz = rig.loop.rate_Hz
    cyclic = [RepeatedFrame("SYNC", 0, rate_Hz)]
    others = [RepeatedFrame(f"{name} heartbeat", 1, 1 / options.heartbeat_s) for name, options in devices.items()]
    for name, options in devices.items():
        for pdo, size, syncs in options.process_data():
            if syncs == 1:
                cyclic.append(RepeatedFrame(f"{name} {pdo}", size, rate_Hz))
            else:
                others.append(RepeatedFrame(f"{name} {pdo} every {syncs} cycles", size, rate_Hz / syncs))
    period_s = our_heartbeat_period_s(rig, bus)
    if period_s:
        others.append(RepeatedFrame("our heartbeat", 1, 1 / period_s))
    return BusLoad(bus, rate_Hz, tuple(cyclic), tuple(others))
