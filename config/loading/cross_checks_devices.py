"""What is wrong with the devices of a rig file as their drivers declare them, with the line of each problem.

On the plain content, as cross_checks, so that it is told together with what the schema finds. Not a matter of reading a file: a rig
in a log is read without its drivers, so only `check` and what opens devices asks here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import GenericAlias
from typing import Any, cast

from config.errors import ConfigError
from config.options.device_options import DeviceOptions, RigNames
from config.options.driver_options import SHIPPED, factories, members, options_schema
from config.options.partly_right import as_far_as_right
from config.options.plug_in_code import loaded, try_declarations, working
from config.options.plug_in_fields import try_fields
from config.options.plug_ins import DRIVERS
from config.parsing.nearest import nearest_text
from config.parsing.problems import Problem
from config.parsing.validation import validated
from config.parsing.yaml_tree import YamlTree


@dataclass(frozen=True, slots=True)
class DeclaredDevices:
    """The devices whose options can be used, by name, and every problem found on the way and between them."""

    options: dict[str, DeviceOptions]
    problems: list[Problem]


def declared_devices(tree: YamlTree) -> DeclaredDevices:
    """Options, channels, addresses and what each device demands of its entry in the rig file."""
    options: dict[str, DeviceOptions] = {}
    partly: dict[str, DeviceOptions] = {}
    problems: list[Problem] = []
    for name, device in _mapping(tree, "devices").items():
        if isinstance(device, dict) and isinstance(device.get("driver"), str):
            found, wrong = _options(tree, name, device)
            problems += wrong
            if found is not None:
                options[name] = found
            elif wrong and (usable := as_far_as_right(device)) is not None:
                partly[name] = usable
    between = [problem for check in (_served, _proofs, _addresses) for problem in check(tree, options)]
    channels = [problem for check in (_inputs, _outputs) for problem in check(tree, {**partly, **options})]
    return DeclaredDevices(options, [*problems, *between, *channels])


def _options(tree: YamlTree, name: str, device: Mapping[str, Any]) -> tuple[DeviceOptions | None, list[Problem]]:
    driver, path = device["driver"], ("devices", name, "driver")
    known = sorted(factories())
    if driver not in known:
        advice = f"Drivers: {', '.join(known)}. Or install the plug-in that brings it (entry-point group {DRIVERS})."
        return None, [tree.problem(path, f"there is no driver {driver!r}{nearest_text(driver, known)}", next_step=advice)]
    try:
        return _declared(tree, name, device)
    except ConfigError as error:
        what = f"devices.{name}: {error.refusal.what}"
        return None, [tree.problem(path, what, value=error.refusal.value, next_step=error.refusal.next_step)]


def _declared(tree: YamlTree, name: str, device: Mapping[str, Any]) -> tuple[DeviceOptions | None, list[Problem]]:
    """ConfigError for what a plug-in's code raises: the daemon could not use it either."""
    driver, written = device["driver"], device.get("options") or {}
    schema = options_schema(driver)
    if driver not in SHIPPED:
        loaded(factories()[driver], driver)
        for member in members(schema) if schema is not None else ():
            try_fields(driver, member)
    if schema is None or not isinstance(written, dict):
        return None, []  # the schema of the rig file says that options are a section
    annotation: Any = schema
    for _ in ("options", name, "devices"):  # so that a problem has its place in the whole file
        annotation = GenericAlias(dict, (str, annotation))
    with working(driver, "the class of options"):
        content, problems = validated(annotation, replace(tree, plain={"devices": {name: {"options": written}}}))
    if problems:
        return None, problems
    options = cast(DeviceOptions, content["devices"][name]["options"])
    if driver not in SHIPPED:
        try_declarations(driver, options, _rig_names(tree))
    return options, []


def _served(tree: YamlTree, devices: Mapping[str, DeviceOptions]) -> Iterator[Problem]:
    for name, options in devices.items():
        if options.served_by == "I/O process" and tree.value(("devices", name, "slow")) is not True:
            what, advice = f"devices.{name} must be slow", "Its answers take longer than a cycle of the loop: write slow: true."
            yield tree.problem(("devices", name, "slow"), what, of_key=True, next_step=advice)


def _proofs(tree: YamlTree, devices: Mapping[str, DeviceOptions]) -> Iterator[Problem]:
    for name, options in devices.items():
        path = ("devices", name, "demand_proof")
        if tree.value(path) is True and not options.proves_safe_state:
            driver = tree.value(("devices", name, "driver"))
            what = f"devices.{name}.demand_proof: the driver {driver!r} cannot prove that the device goes safe by itself"
            yield tree.problem(path, what, next_step="Remove demand_proof, or use a driver that can.")


def _inputs(tree: YamlTree, devices: Mapping[str, DeviceOptions]) -> Iterator[Problem]:
    names = _rig_names(tree)
    for signal, entry in _mapping(tree, "signals").items():
        device = str(entry.get("device")) if isinstance(entry, dict) else ""
        blind = not names.sensors and tree.value(("devices", device, "driver")) == "sim"  # check_runnable says that there is no plant
        if device in devices and not blind:
            yield from _known(tree, ("signals", signal, "channel"), device, "input", _channels(devices[device], "input_channels", names))


def _outputs(tree: YamlTree, devices: Mapping[str, DeviceOptions]) -> Iterator[Problem]:
    names = _rig_names(tree)
    taken: dict[tuple[str, str], str] = {}
    for joint, entry in _mapping(tree, "outputs").items():
        device, channel = (str(entry.get("device")), str(entry.get("channel"))) if isinstance(entry, dict) else ("", "")
        path = ("outputs", joint, "channel")
        if device in devices:
            yield from _known(tree, path, device, "output", _channels(devices[device], "output_channels", names))
        first = taken.setdefault((device, channel), joint)
        if first != joint and device:
            yield tree.problem(path, f"outputs.{joint} and outputs.{first} are one channel", value=f"{device} {channel}")


def _channels(options: DeviceOptions, kind: str, names: RigNames) -> Mapping[str, Any] | None:
    """None when they follow from what is wrong in the options."""
    try:
        channels: Mapping[str, Any] = getattr(options, kind)(names)
    except Exception:  # of options that are right in part only, a class may rely on any
        return None
    return channels


def _known(tree: YamlTree, path: tuple[str, ...], device: str, kind: str, channels: Mapping[str, Any] | None) -> Iterator[Problem]:
    channel = tree.value(path)
    if channels is not None and isinstance(channel, str) and channel not in channels:
        what = f"{'.'.join(path)}: the device {device!r} has no {kind} {channel!r}{nearest_text(channel, channels)}"
        yield tree.problem(path, what, next_step=f"Its {kind}s: {', '.join(channels) or 'none'}.")


def _addresses(tree: YamlTree, devices: Mapping[str, DeviceOptions]) -> Iterator[Problem]:
    """Devices on one link must agree about it, and have numbers of their own."""
    taken: dict[tuple[tuple[str, ...], int], str] = {}
    first_on: dict[tuple[str, ...], str] = {}
    for name, options in devices.items():
        address = options.address()
        if address is None:
            continue
        path = ("devices", name, "options", address.option)
        where = f"{address.link[0]} {address.link[-1]}"
        if address.number in address.taken:
            what = f"{'.'.join(path)} is {address.taken[address.number]}"
            yield tree.problem(path, what, value=str(address.number), next_step="Give the device another number.")
        before = taken.setdefault((address.link, address.number), name)
        if before != name and address.alone:
            what = f"{'.'.join(path)}: device {before!r} on {where} has this number too"
            yield tree.problem(path, what, value=str(address.number), next_step="Give one of them another number.")
        first = first_on.setdefault(address.link, name)
        yield from _agreement(tree, name, first, devices)


def _agreement(tree: YamlTree, name: str, first: str, devices: Mapping[str, DeviceOptions]) -> Iterator[Problem]:
    ours, theirs = devices[name].address(), devices[first].address()
    assert ours is not None
    assert theirs is not None
    for option, value in ours.agreed.items():
        if theirs.agreed.get(option) != value:
            path = ("devices", name, "options", *option.split("."))
            what = f"devices.{name} and devices.{first} are on one link and differ in {option}"
            limit = f"{first}: {theirs.agreed.get(option)}"
            yield tree.problem(path, what, value=str(value), limit=limit, next_step="Write the same for both.")


def _rig_names(tree: YamlTree) -> RigNames:
    plant = tree.value(("plant", "sensors"))
    return RigNames(tuple(_mapping(tree, "joints")), tuple(plant) if isinstance(plant, dict) else ())


def _mapping(tree: YamlTree, key: str) -> dict[str, Any]:
    value = tree.value((key,))
    return value if isinstance(value, dict) else {}
