"""Where the device verbs look: a rig file, one CAN bus, one Modbus host or one serial line, as one word of the command line.

my_rig.yaml   ornl_testbed_can      every bus and line that the rig names
socketcan:can0                      a CAN bus by python-can's interface and channel
tcp:192.168.1.20:502                a Modbus host; its port may be a range for `scan`
rtu:/dev/ttyUSB0                    a serial line
"""

from __future__ import annotations

import argparse
import json
import re
from dataclasses import dataclass, field
from typing import Any, TypeVar

from config.errors import ConfigError
from config.loading.load import LoadedRig, load_rig
from config.options.canopen_options import CanBus, CanopenOptions
from config.options.device_options import DeviceOptions
from config.options.driver_options import rig_options
from config.options.modbus_options import RtuOptions, TcpOptions
from config.parsing.problems import config_error
from config.parsing.validation import validated
from config.parsing.yaml_tree import parse
from daemon.cli.devices.meant_for import CAN, RIG, RTU, TCP, refuse_others

_NO_CHANNEL = {"register": {"address": 0}}  # a unit that is looked for has no channels yet
_RANGE = re.compile(r"(\d+)(?:-(\d+))?")
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class DeviceLinks:
    """The links meant, and what the rig file says of each device on them."""

    buses: list[CanBus]
    lines: list[TcpOptions | RtuOptions]
    rig: LoadedRig | None = None
    declared: dict[str, DeviceOptions] = field(default_factory=dict)

    def device_at(self, link: tuple[str, ...], number: int) -> str:
        """The rig's name of the device with this number there; empty when it has none."""
        for name, options in self.declared.items():
            address = options.address()
            if address is not None and (address.link, address.number) == (link, number):
                return name
        return ""


def numbers(text: str, where: str, low: int, high: int) -> list[int]:
    """ "1-4,7" → [1, 2, 3, 4, 7]. ConfigError for anything else."""
    found: list[int] = []
    for part in text.split(","):
        match = _RANGE.fullmatch(part.strip())
        first = int(match[1]) if match else -1
        last = int(match[2] or match[1]) if match else -1
        if not low <= first <= last <= high:
            limit, mend = f"{low} to {high}", {text: f"{low}-{min(low + 15, high)}"}
            raise ConfigError("not a range of numbers", value=text, limit=limit, where=where, next_step="Write 1-16 or 1,3,7.", mend=mend)
        found += range(first, last + 1)
    return list(dict.fromkeys(found))


def section(annotation: type[T], content: dict[str, Any], where: str) -> T:
    """A section of options from words of the command line. ConfigError that names each wrong one."""
    made, problems = validated(annotation, parse(json.dumps({key: value for key, value in content.items() if value is not None}), where))
    if problems:
        raise config_error(where, problems)
    found: T = made
    return found


def of_word(arguments: argparse.Namespace) -> DeviceLinks:
    """What WHERE and the settings beside it mean."""
    kind, colon, rest = arguments.where.partition(":")
    if re.fullmatch(r"v?s?l?can\d+", arguments.where):
        bus = f"socketcan:{arguments.where}"
        raise ConfigError("a CAN bus is INTERFACE:CHANNEL", value=arguments.where, next_step=f"Write {bus}.", mend={arguments.where: bus})
    is_rig = not colon or arguments.where.endswith((".yaml", ".yml"))
    refuse_others(arguments, RIG if is_rig else kind if kind in (TCP, RTU) else CAN)
    if is_rig:
        return _of_rig(arguments.where)
    if kind == "tcp":
        return DeviceLinks([], _hosts(rest, arguments))
    if kind == "rtu":
        return DeviceLinks([], _serial(rest, arguments))
    rates = _listed(arguments.bitrate) or ["1 Mbit/s"]
    return DeviceLinks([section(CanBus, {"interface": kind, "channel": rest, "bitrate": rate}, arguments.where) for rate in rates], [])


def _of_rig(name: str) -> DeviceLinks:
    loaded = load_rig(name)
    declared = rig_options(loaded.rig)
    buses = {options.bus.key: options.bus for options in declared.values() if isinstance(options, CanopenOptions)}
    lines: dict[tuple[str, ...], TcpOptions | RtuOptions] = {}
    for options in declared.values():
        if isinstance(options, (TcpOptions, RtuOptions)):
            lines.setdefault(options.address().link, options)
    return DeviceLinks(list(buses.values()), list(lines.values()), loaded, declared)


def _hosts(rest: str, arguments: argparse.Namespace) -> list[TcpOptions | RtuOptions]:
    host, _, ports = rest.partition(":")
    options = {"transport": "tcp", "host": host, "answer_timeout": arguments.answer_timeout, "channels": _NO_CHANNEL}
    return [section(TcpOptions, {**options, "port": port}, arguments.where) for port in numbers(ports or "502", "port", 1, 65535)]


def _serial(port: str, arguments: argparse.Namespace) -> list[TcpOptions | RtuOptions]:
    made: list[TcpOptions | RtuOptions] = []
    for baud_rate in _listed(arguments.baud_rate) or [19200]:
        for parity in _listed(arguments.parity) or ["even"]:
            line = {"transport": "rtu", "port": port, "baud_rate": baud_rate, "parity": parity, "stop_bits": arguments.stop_bits}
            content = {**line, "answer_timeout": arguments.answer_timeout, "channels": _NO_CHANNEL}
            made.append(section(RtuOptions, content, arguments.where))
    return made


def _listed(value: Any) -> list[Any]:
    return [] if value is None else value if isinstance(value, list) else [value]
