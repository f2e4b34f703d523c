"""Drivers by name, and the options of their devices: the shipped ones stand here, plug-ins come with entry points."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from importlib.metadata import EntryPoint
from typing import Any, cast

from config.errors import ConfigError, Refusal
from config.options.canopen_options import EncoderOptions, IoOptions, ValveOptions
from config.options.device_options import DeviceOptions, RigNames
from config.options.modbus_options import AnyModbusOptions
from config.options.plug_in_code import loaded, working
from config.options.plug_ins import DRIVERS, OPTIONS, installed
from config.options.sim_options import SimOptions
from config.parsing.validation import validated
from config.parsing.yaml_tree import parse
from config.schema.model_fields import bare, union_members
from config.schema.rig import Device, Rig


@dataclass(frozen=True, slots=True)
class ShippedDriver:
    """`options`: a subclass of DeviceOptions or a union of such; `factory`: module:function, imported when a device asks for it."""

    options: Any
    factory: str


SHIPPED = {
    "sim": ShippedDriver(SimOptions, "drivers.sim:create"),
    "canopen_encoder_406": ShippedDriver(EncoderOptions, "drivers.canopen.encoder_406:create"),
    "canopen_valve_408": ShippedDriver(ValveOptions, "drivers.canopen.valve_408:create"),
    "canopen_io_401": ShippedDriver(IoOptions, "drivers.canopen.io_401:create"),
    "modbus": ShippedDriver(AnyModbusOptions, "drivers.modbus:create"),
}


def factories() -> dict[str, EntryPoint]:
    """Name → where the factory is, of every driver that a rig file may name: shipped and of installed plug-ins."""
    shipped = {name: EntryPoint(name, driver.factory, DRIVERS) for name, driver in SHIPPED.items()}
    return {**installed(DRIVERS), **shipped}


def options_schema(driver: str) -> Any | None:
    """A subclass of DeviceOptions or a union of such; None for a plug-in that declares none and for a driver nobody knows.

    ConfigError when a plug-in's declaration can't be loaded or is no DeviceOptions.
    """
    if driver in SHIPPED:
        return SHIPPED[driver].options
    point = installed(OPTIONS).get(driver)
    if point is None:
        return None
    schema = loaded(point, driver)
    if not all(isinstance(member, type) and issubclass(member, DeviceOptions) for member in members(schema)):
        advice = "Derive it from config.options.device_options.DeviceOptions."
        raise ConfigError(f"the options of the driver {driver!r} are no DeviceOptions", value=point.value, next_step=advice)
    return schema


def members(schema: Any) -> list[Any]:
    """The classes of a union of options; the class itself where there is one alone."""
    return [member for _, member in union_members(schema)] or [bare(schema)]


def device_options(name: str, device: Device) -> DeviceOptions | None:
    """The options of the rig's device `name` as its driver declares them; None for a driver that declares none.

    Raises ConfigError that lists every problem as devices.NAME.options: KEY ..., without line numbers: the options are plain data here.
    """
    schema = options_schema(device.driver)
    if schema is None:
        return None
    where = f"devices.{name}.options"
    with working(device.driver, "the class of options"):
        options, problems = validated(schema, parse(json.dumps(device.options, default=str), where))
    if problems:
        raise _config_error(tuple(replace(problem.refusal, where=where) for problem in problems), where)
    return cast(DeviceOptions, options)


def rig_options(rig: Rig) -> dict[str, DeviceOptions]:
    """Every device whose driver declares its options. ConfigError as device_options()."""
    found = ((name, device_options(name, device)) for name, device in rig.devices.items())
    return {name: options for name, options in found if options is not None}


def rig_names(rig: Rig) -> RigNames:
    """What devices may need to know of a rig."""
    return RigNames(tuple(rig.joints), tuple(rig.plant.sensors) if rig.plant else ())


def _config_error(refusals: tuple[Refusal, ...], where: str) -> ConfigError:
    if len(refusals) == 1:
        only = refusals[0]
        return ConfigError(only.what, value=only.value, limit=only.limit, where=where, next_step=only.next_step)
    lines = "".join(f"\n  {refusal.text()}" for refusal in refusals)
    return ConfigError(f"{len(refusals)} problems in {where}:{lines}", problems=refusals)
