"""Makes drivers by name: the shipped ones, and those of installed plug-ins (entry-point group `longreach.drivers`)."""

from __future__ import annotations

import difflib
from typing import Protocol, cast

from config.errors import ConfigError, DriverError
from config.options.driver_options import factories
from config.options.plug_in_code import loaded
from config.schema.rig import Device, Rig
from drivers.contract import Driver


class DriverFactory(Protocol):
    """What a plug-in registers. `lockstep`: time is virtual and comes with every read and write."""

    def __call__(self, name: str, device: Device, rig: Rig, lockstep: bool) -> Driver: ...


def known_drivers() -> tuple[str, ...]:
    """Names that may stand in a rig file's `devices: … driver:`."""
    return tuple(sorted(factories()))


def create(name: str, device: Device, rig: Rig, lockstep: bool) -> Driver:
    """The driver of the rig's device `name`, not yet open.

    Raises DriverError with the known names when there is no such driver, or when the plug-in cannot be imported.
    """
    where = f"devices.{name}.driver"
    point = factories().get(device.driver)
    if point is None:
        nearest = difflib.get_close_matches(device.driver, known_drivers(), 1)
        advice = f"Did you mean {nearest[0]!r}?" if nearest else "Install the plug-in that brings it (entry-point group longreach.drivers)."
        raise DriverError("unknown driver", value=device.driver, limit=", ".join(known_drivers()), where=where, next_step=advice)
    try:
        factory = cast(DriverFactory, loaded(point, device.driver))
    except ConfigError as error:
        raise DriverError(error.refusal.what, value=error.refusal.value, where=where, next_step=error.refusal.next_step) from error
    return factory(name, device, rig, lockstep)
