"""The numbers of one device that are shown: where each stands, its type, and the signal of the rig file that scales it."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from config.errors import ConfigError, DriverError, UsageError
from config.loading.load import LoadedRig
from config.loading.stated_units import conversion, stated_units
from config.options.canopen_options import CanBus, CanopenOptions
from config.options.device_options import DeviceOptions
from config.options.driver_options import rig_names
from config.options.modbus_options import REGISTERS, ModbusChannel, RtuOptions, TcpOptions
from config.parsing.nearest import nearest, nearest_text
from config.schema.section import unit_of
from config.schema.signals import AnySignal
from config.stated_sentences import Conversion
from daemon.cli.devices.meant_for import RIG_CAN, RIG_MODBUS, refuse_others
from daemon.cli.devices.where import DeviceLinks, of_word, section
from drivers.canopen.node_reader import NodeReader
from drivers.inspection.can_scan import Identity, identity
from drivers.inspection.objects import NodeObject, of_channel, of_eds
from drivers.inspection.objects import of_word as object_of_word
from drivers.inspection.sources import NodeSource, Source, UnitSource, can_to_ask

_OF_A_COUNT = 1e-6  # less is what adding leaves of a zero


@dataclass(frozen=True, slots=True)
class Scaling:
    """Engineering value = offset + scale × raw, shown as `shown` converts it from SI."""

    signal: str
    scale: float
    offset: float
    shown: Conversion

    def value(self, raw: float) -> float:
        _, factor, zero = self.shown
        value = factor * (self.offset + self.scale * raw) + zero
        return value if abs(value) > _OF_A_COUNT * abs(factor * self.scale) else 0.0


@dataclass(frozen=True, slots=True)
class DeviceNumber:
    """`where`: object or register; `name`: of the dictionary or the rig file's channel."""

    where: str
    name: str
    type: str
    scaling: Scaling | None = None


@dataclass(frozen=True, slots=True)
class ReadDevice:
    """What is read, and what the device says it is."""

    title: str
    numbers: list[DeviceNumber]
    source: Source


@contextmanager
def device(arguments: argparse.Namespace) -> Iterator[ReadDevice]:
    """The device of the command line, open for reading. DriverError when it cannot be asked or does not answer."""
    where = of_word(arguments)
    named = _named(where, arguments)
    if named is not None:
        refuse_others(arguments, RIG_CAN if isinstance(named, CanopenOptions) else RIG_MODBUS)
    if isinstance(named, CanopenOptions):
        with _node(where, named.bus, named.node, named, arguments) as found:
            yield found
    elif isinstance(named, (TcpOptions, RtuOptions)):
        with _unit(named, _scalings(where.rig, arguments.device)) as found:
            yield found
    elif where.buses:
        node = _needed(arguments.node, "--node", arguments.where)
        with _node(where, where.buses[0], node, None, arguments) as found:
            yield found
    else:
        with _unit(_registers(where.lines[0], arguments), {}) as found:
            yield found


def _named(where: DeviceLinks, arguments: argparse.Namespace) -> DeviceOptions | None:
    if where.rig is None:
        return None
    known = list(where.rig.rig.devices)
    if arguments.device not in known:
        hint = nearest_text(arguments.device or "", known)
        meant = nearest(arguments.device or "", known) or known[0]
        what = f"the rig has no device {arguments.device!r}{hint}" if arguments.device else "which device of the rig?"
        advice = f"Devices: {', '.join(known)}. `longreach device {arguments.verb} {arguments.where} {meant}`"
        raise UsageError(what, where="DEVICE", next_step=advice)
    options = where.declared.get(arguments.device)
    if not isinstance(options, (CanopenOptions, TcpOptions, RtuOptions)):
        driver = where.rig.rig.devices[arguments.device].driver
        advice = "Start the daemon; `longreach status --watch` shows what its driver reads."
        raise DriverError("this device is read by its driver alone", value=driver, where=arguments.device, next_step=advice)
    return options


def _needed(number: int | None, option: str, where: str) -> int:
    if number is None:
        advice = f"`longreach device scan {shlex.quote(where)}` shows who is there."
        raise UsageError(f"{option} is missing", where=option, next_step=advice)
    return number


@contextmanager
def _node(where: DeviceLinks, bus: CanBus, node: int, named: CanopenOptions | None, arguments: argparse.Namespace) -> Iterator[ReadDevice]:
    with can_to_ask(bus) as can_bus:
        who = identity(can_bus, node)
        if who is None:
            advice = f"`longreach device scan {arguments.where}` shows who answers; check its power, cable, node number and the bit rate."
            raise DriverError("the node does not answer", value=node, where=f"{bus.interface} {bus.channel}", next_step=advice)
        listed = of_eds(Path(arguments.eds) if arguments.eds else None, who.profile, node)
        objects = _objects(where, named, listed, arguments)
        scalings = _scalings(where.rig, arguments.device)
        numbers = [DeviceNumber(each.place, each.name, each.type or "by size", scalings.get(each.name)) for each in objects]
        with NodeReader(can_bus, node, arguments.device or f"{bus.channel}") as reader:
            yield ReadDevice(_who(node, who), numbers, NodeSource(reader, objects))


def _who(node: int, who: Identity) -> str:
    profile = f"CiA {who.profile}" if who.profile else "no CiA profile"
    name = f", {who.name}" if who.name else ""
    numbers = {"vendor": who.vendor, "product": who.product, "revision": who.revision, "serial": who.serial}
    shown = ", ".join(f"{key} 0x{number:X}" for key, number in numbers.items() if number is not None)
    return f"node {node}: {profile}{name}; {shown}"


def _objects(
    where: DeviceLinks, named: CanopenOptions | None, listed: Mapping[tuple[int, int], NodeObject], arguments: argparse.Namespace
) -> list[NodeObject]:
    """Those asked for; else the channels of the rig file's device; else what the dictionary lists."""
    if arguments.object:
        return [object_of_word(word, dict(listed)) for word in arguments.object]
    if named is not None and where.rig is not None:
        names = rig_names(where.rig.rig)
        channels = {**named.input_channels(names), **{f"{name} (set)": found for name, found in named.output_channels(names).items()}}
        return [of_channel(name, channel) for name, channel in channels.items()]
    if not listed:
        advice = "Name them (--object 1000 1018:1), or give the maker's dictionary with --eds FILE."
        raise ConfigError(
            "the objects of this node are not known: no shipped dictionary of its profile", where="--object", next_step=advice
        )
    return list(listed.values())


@contextmanager
def _unit(options: TcpOptions | RtuOptions, scalings: Mapping[str, Scaling]) -> Iterator[ReadDevice]:
    source = UnitSource(options)
    try:
        link = " ".join(options.address().link)
        numbers = [_register(name, channel, scalings.get(name)) for name, channel in options.channels.items()]
        yield ReadDevice(f"{link}, unit {options.unit_id}", numbers, source)
    finally:
        source.close()


def _register(name: str, channel: ModbusChannel, scaling: Scaling | None) -> DeviceNumber:
    order = f", {channel.word_order} word first" if REGISTERS[channel.type] > 1 else ""
    words = order.replace("big word", "high word").replace("little word", "low word")
    return DeviceNumber(f"{channel.table} {channel.address}", name, f"{channel.type}{words}", scaling)


def _registers(line: TcpOptions | RtuOptions, arguments: argparse.Namespace) -> TcpOptions | RtuOptions:
    """Numbers of one type, one after the other."""
    type_ = arguments.type or "uint16"
    common = {"table": arguments.table, "type": type_, "word_order": arguments.word_order}
    each, first = REGISTERS[type_], arguments.address or 0
    channels = {
        f"number {number}": section(ModbusChannel, {**common, "address": first + each * number}, "--address")
        for number in range(arguments.count or 8)
    }
    return line.model_copy(update={"unit_id": _needed(arguments.unit, "--unit", arguments.where), "channels": channels})


def _scalings(rig: LoadedRig | None, device_name: str | None) -> dict[str, Scaling]:
    """Channel → how the rig file scales it, shown in the unit in which the file states the signal's range."""
    if rig is None:
        return {}
    stated = stated_units(rig.text)
    return {signal.channel: scaling(name, signal, stated) for name, signal in rig.rig.signals.items() if signal.device == device_name}


def scaling(name: str, signal: AnySignal, stated: Mapping[str, str]) -> Scaling:
    """Of one signal."""
    unit = unit_of(type(signal.calibration).model_fields["offset"]) or ""
    shown = conversion(unit, stated[name]) if name in stated else None
    return Scaling(name, signal.calibration.scale, signal.calibration.offset, shown or (unit, 1.0, 0.0))
