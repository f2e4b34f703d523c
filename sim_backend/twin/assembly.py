"""From a rig file to a bench: which devices there are, which sensor each shows, which joint each moves."""

from __future__ import annotations

from collections.abc import Mapping

from config.errors import ConfigError
from config.options.canopen_options import CanBus, EncoderOptions, IoOptions, ValveOptions
from config.options.canopen_rig import canopen_devices
from config.schema.rig import Rig
from sim_backend.plant import SimulatedRig
from sim_backend.twin.bench import SimulatedDevices, Update, Volts
from sim_backend.twin.can.analog_io import CHANNELS, AnalogIo
from sim_backend.twin.can.can_node import CanNode
from sim_backend.twin.can.encoder import Encoder
from sim_backend.twin.can.object_store import Send
from sim_backend.twin.can.valve import Valve
from sim_backend.twin.plant_feed import PlantFeed


def can_bus(rig: Rig) -> CanBus | None:
    """The CAN bus of the rig; None when it has none. ConfigError when there are two: a twin serves one."""
    buses = {options.bus.key: options.bus for options in canopen_devices(rig).values()}
    if len(buses) > 1:
        named = ", ".join(channel for _, channel in buses)
        raise ConfigError(
            "a twin serves one CAN bus", value=named, where=rig.name, next_step="Put the devices on one bus for the simulation."
        )
    return next(iter(buses.values()), None)


def bench(rig: Rig, plant: SimulatedRig, send: Send) -> SimulatedDevices:
    """The bench of this rig, which sends its frames through `send`. An input whose signal the plant has no sensor for shows 0."""
    feed = PlantFeed(rig, plant)
    nodes: dict[str, CanNode] = {}
    updates: list[Update] = []
    for name, options in canopen_devices(rig).items():
        if isinstance(options, EncoderOptions):
            nodes[name] = _encoder(rig, name, options, send, feed, updates)
        elif isinstance(options, ValveOptions):
            nodes[name] = Valve(name, options.node, send, tuple(options.fault_reactions), options.failsafe_spool)
        elif isinstance(options, IoOptions):
            nodes[name] = _io(rig, name, options, send, updates)
    volts = [_volts(rig, joint, nodes, feed.period_s) for joint in rig.joints]
    return SimulatedDevices(feed, list(nodes.values()), volts, updates)


def _encoder(rig: Rig, name: str, options: EncoderOptions, send: Send, feed: PlantFeed, updates: list[Update]) -> Encoder:
    encoder = Encoder(name, options.node, send, options.resolution or 0)
    signal = _signals(rig, name).get("position")
    if signal is not None:
        updates.append(lambda counts: encoder.measure(counts[signal], feed.period_s))
    return encoder


def _io(rig: Rig, name: str, options: IoOptions, send: Send, updates: list[Update]) -> AnalogIo:
    module = AnalogIo(name, options.node, send, options.loopback)
    shown = _signals(rig, name)
    signals = [shown.get(f"input_{number}") for number in range(1, CHANNELS + 1)]
    updates.append(lambda counts: module.measure([counts.get(signal or "", 0.0) for signal in signals]))
    return module


def _signals(rig: Rig, device: str) -> Mapping[str, str]:
    """Channel → signal of one device."""
    return {signal.channel: name for name, signal in rig.signals.items() if signal.device == device}


def _volts(rig: Rig, joint: str, nodes: Mapping[str, CanNode], period_s: float) -> Volts:
    """What the joint's valve amplifier gets: the device's demand, back in volts."""
    output = rig.outputs[joint]
    node = nodes.get(output.device)
    if isinstance(node, Valve):
        return lambda now_ns: node.move(period_s, now_ns) / output.scale
    if isinstance(node, AnalogIo):
        options = canopen_devices(rig)[output.device]
        assert isinstance(options, IoOptions)
        number, counts_per_unit = int(output.channel.removeprefix("output_")) - 1, options.counts_per_volt * output.scale
        return lambda now_ns: node.terminal(number, now_ns) / counts_per_unit
    return lambda now_ns: 0.0
