"""The fields of a plug-in's class of options: an unknown unit and a default that is refused are its maker's faults, not the user's.

Told before what the rig file says is looked at: a user would be sent to a place in the rig file where nothing is wrong.
"""

from __future__ import annotations

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from config.errors import ConfigError, UnitError
from config.options.device_options import DeviceOptions
from config.options.plug_in_code import declared_at
from config.schema.section import unit_of
from config.units import to_si


def try_fields(driver: str, options: type[DeviceOptions]) -> None:
    """ConfigError for the first field that nobody can use as it is declared."""
    for name in options.model_fields:
        _try_unit(driver, options, name)
    for error in _refused_defaults(options):
        name = str(error["loc"][0])
        what = f"the option {_key(options, name)!r} of the driver {driver!r} has a default that it refuses"
        value = f"{error['input']!r} {unit_of(options.model_fields[name]) or ''}".rstrip()
        raise ConfigError(what, value=value, next_step=f"{error['msg']}: mend it at {declared_at(options, name)}.")


def _key(options: type[DeviceOptions], name: str) -> str:
    return options.model_fields[name].alias or name


def _try_unit(driver: str, options: type[DeviceOptions], name: str) -> None:
    unit = unit_of(options.model_fields[name])
    if not unit:
        return
    try:
        to_si(f"1 {unit}", unit)
    except UnitError as error:
        what = f"the option {_key(options, name)!r} of the driver {driver!r} is declared in an unknown unit"
        raise ConfigError(what, value=repr(unit), next_step=f"Mend it at {declared_at(options, name)}.") from error


def _refused_defaults(options: type[DeviceOptions]) -> list[ErrorDetails]:
    """What pydantic says of the fields that an empty section leaves at their defaults."""
    try:
        options.model_validate({})
    except ValidationError as errors:
        return [error for error in errors.errors(include_url=False) if error["type"] != "missing" and error["loc"]]
    except Exception:  # code of its own that relies on a required option
        return []
    return []
