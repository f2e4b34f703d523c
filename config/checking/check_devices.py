"""What `longreach check` says about devices: what cannot work, and what works though it is seldom meant."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

from config.checking.finding import Finding, error_at, warning_at
from config.loading.cross_checks_devices import declared_devices
from config.loading.stated_units import conversion, stated_units
from config.options.canopen_options import CanopenOptions, EncoderOptions
from config.options.canopen_rig import HEARTBEATS_PER_TIMEOUT
from config.options.device_options import Channel, DeviceOptions
from config.options.driver_options import SHIPPED, factories, rig_names
from config.options.plug_ins import OPTIONS, installed
from config.parsing.yaml_tree import YamlTree
from config.readable import number
from config.schema.rig import Rig
from config.schema.section import unit_of
from config.schema.signals import Signal

_CALIBRATED = 0.02  # by more no calibrated scale differs from the one on the encoder's label


def check_devices(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    """Findings about the devices whose options can be used, and about those whose driver says nothing of itself."""
    devices = declared_devices(tree).options
    named = [f"{name} ({rig.devices[name].driver}{_place(options)})" for name, options in devices.items()]
    if len(devices) == len(rig.devices):
        yield Finding("ok", f"options, channels and addresses of every device are right: {', '.join(named)}")
    yield from _undeclared(rig, tree)
    for name, options in devices.items():
        for option, what in options.warnings():
            yield warning_at(tree, ("devices", name, "options", option), f"devices.{name}.options.{option}: {what}")
    yield from _served(rig, tree, devices)
    yield from _heartbeats(rig, tree, devices)
    yield from _shared_units(tree, devices)
    yield from _shared_channels(rig, tree)
    yield from _outputs(rig, tree, devices)
    yield from _inputs(rig, tree, devices)
    yield from _resolutions(rig, tree, devices)


def _place(options: DeviceOptions) -> str:
    address = options.address()
    return "" if address is None else f", {' '.join(address.link[1:])} {address.option} {address.number}"


def _undeclared(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    for name, device in rig.devices.items():
        if device.driver in factories() and device.driver not in SHIPPED and device.driver not in installed(OPTIONS):
            what = f"the driver {device.driver!r} declares no options (entry-point group {OPTIONS})"
            text = f"devices.{name}: {what}: its options, channels and address cannot be checked without the device"
            yield warning_at(tree, ("devices", name, "driver"), text)


def _served(rig: Rig, tree: YamlTree, devices: Mapping[str, DeviceOptions]) -> Iterator[Finding]:
    for name, options in devices.items():
        if options.served_by == "loop" and rig.devices[name].slow:
            text = f"devices.{name}.slow: its bus is served by the loop; from the I/O process a second SYNC would come"
            yield warning_at(tree, ("devices", name, "slow"), f"{text}. Remove slow: true.")


def _heartbeats(rig: Rig, tree: YamlTree, devices: Mapping[str, DeviceOptions]) -> Iterator[Finding]:
    """A device that supervises us must not miss us between two cycles."""
    least_s = HEARTBEATS_PER_TIMEOUT / rig.loop.rate_Hz
    for name, options in devices.items():
        timeout_s = rig.devices[name].timeout_s
        if isinstance(options, CanopenOptions) and options.must_prove() and timeout_s < least_s * (1 - 1e-9):
            text = f"devices.{name}.timeout is {1e3 * timeout_s:g} ms; {HEARTBEATS_PER_TIMEOUT} heartbeats of ours in that time need"
            text = f"{text} {1e3 * least_s:g} ms at loop.rate {rig.loop.rate_Hz:g} Hz: the device would call us dead. Allow it longer."
            yield error_at(tree, ("devices", name, "timeout"), text)


def _shared_units(tree: YamlTree, devices: Mapping[str, DeviceOptions]) -> Iterator[Finding]:
    """Devices that are polled each in its own time; those with numbers of their own take turns on a serial line."""
    first: dict[tuple[object, ...], str] = {}
    for name, options in devices.items():
        address = options.address()
        if address is None or address.alone:
            continue
        path = ("devices", name, "options", address.option)
        before = first.setdefault((address.link, address.number), name)
        if before != name:
            text = f"devices.{name} and devices.{before} are one unit, number {address.number} at {':'.join(address.link[1:])}"
            yield warning_at(tree, path, f"{text}: each asks it in its own time. One device can hold all channels.")


def _shared_channels(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    first: dict[tuple[str, str], str] = {}
    for name, signal in rig.signals.items():
        before = first.setdefault((signal.device, signal.channel), name)
        if before != name:
            text = f"signals.{name} and signals.{before} are one channel, {signal.channel} of {signal.device}"
            yield warning_at(tree, ("signals", name, "channel"), text)


def _outputs(rig: Rig, tree: YamlTree, devices: Mapping[str, DeviceOptions]) -> Iterator[Finding]:
    names = rig_names(rig)
    for joint, output in rig.outputs.items():
        options = devices.get(output.device)
        channel = options.output_channels(names).get(output.channel) if options else None
        if channel is not None:
            yield from _reach(rig, tree, joint, channel)


def _reach(rig: Rig, tree: YamlTree, joint: str, channel: Channel) -> Iterator[Finding]:
    """A command that the device cannot follow saturates in it, unseen by the servo."""
    scale, limit_V = rig.outputs[joint].scale, rig.joints[joint].command_limit_V
    if channel.high is None or abs(scale) * limit_V <= channel.high * (1 + 1e-3):
        return
    asked = f"joints.{joint}.command_limit, {limit_V:g} V, times scale {scale:g} is {abs(scale) * limit_V:g} {channel.unit}".rstrip()
    text = f"outputs.{joint}: {asked}, but the device ends at {channel.high:.6g} {channel.unit}".rstrip()
    yield warning_at(tree, ("outputs", joint, "scale"), text)


def _inputs(rig: Rig, tree: YamlTree, devices: Mapping[str, DeviceOptions]) -> Iterator[Finding]:
    names = rig_names(rig)
    for name, signal in rig.signals.items():
        scale, path = signal.calibration.scale, ("signals", name, "calibration")
        if scale == 0:
            yield warning_at(tree, path, f"{name}: calibration.scale is 0: the value would never change")
            continue
        options = devices.get(signal.device)
        channel = options.input_channels(names).get(signal.channel) if options else None
        if channel is None or channel.low is None or channel.high is None:
            continue
        ends = sorted(signal.calibration.offset + scale * count for count in (channel.low, channel.high))
        owner = name.rpartition(".")[0] if name.endswith(".position") else name
        wanted = rig.joints[owner].travel if owner in rig.joints else (signal.low, signal.high)
        if (wanted[0] is not None and wanted[0] < ends[0]) or (wanted[1] is not None and wanted[1] > ends[1]):
            shown = _shower(tree, owner, signal)
            what = "the joint's travel" if owner in rig.joints else "low to high"
            means = f"counts {channel.low:.6g} to {channel.high:.6g} of {signal.channel} mean {shown(ends)}"
            yield warning_at(tree, path, f"{name}: {means}; {what} is {shown(wanted)}")


def _resolutions(rig: Rig, tree: YamlTree, devices: Mapping[str, DeviceOptions]) -> Iterator[Finding]:
    """What the driver makes sure of when it opens an encoder says what one count is worth, too."""
    for name, signal in rig.signals.items():
        options, scale = devices.get(signal.device), abs(signal.calibration.scale)
        if not (isinstance(options, EncoderOptions) and options.resolution and signal.channel == "position" and scale):
            continue
        own, unit = (2 * math.pi / options.resolution, "rad") if signal.measures == "angle" else (1e-9 * options.resolution, "m")
        if not math.isclose(scale, own, rel_tol=_CALIBRATED):
            stated = f"devices.{signal.device}.options.resolution, {options.resolution}, makes a count of {name} {own:.6g} {unit}"
            text = f"{name}: calibration.scale is {scale:.6g} {unit}; {stated}, unless a gear or lever stands between"
            yield warning_at(tree, ("signals", name, "calibration", "scale"), text)


def _shower(tree: YamlTree, owner: str, signal: Signal) -> Callable[[Sequence[float | None]], str]:
    """Two values of a signal as a range in the unit in which the file states that of `owner`."""
    unit = unit_of(type(signal).model_fields["low"]) or ""
    shown, factor, offset = conversion(unit, stated_units(tree.text).get(owner, unit)) or (unit, 1.0, 0.0)
    return lambda values: " to ".join("any" if each is None else number(factor * each + offset) for each in values) + f" {shown}"
