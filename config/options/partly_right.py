"""Options of which some are wrong, as far as they are right: enough to say which channels the device has, and no more."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast, get_args, get_origin

from pydantic import TypeAdapter, ValidationError

from config.errors import ConfigError
from config.options.device_options import DeviceOptions
from config.options.driver_options import options_schema
from config.schema.model_fields import bare, fields_of, member_for, union_members
from config.schema.section import Section


def as_far_as_right(device: Mapping[str, Any]) -> DeviceOptions | None:
    """The options of this entry of `devices`, unchecked; None when nothing is known of its driver's."""
    written = device.get("options") or {}
    try:
        schema = options_schema(str(device.get("driver")))
    except ConfigError:
        return None
    if schema is None or not isinstance(written, dict):
        return None
    try:
        member = member_for(schema, written) if union_members(schema) else bare(schema)
        return cast(DeviceOptions, _section(member, written))
    except Exception:  # what a plug-in's class does with options that are wrong
        return None


def _section(section: type[Section], written: Mapping[str, Any]) -> Section:
    """What is missing has its default or stays away; what is wrong stays as it is written."""
    names = {field.alias or name: name for name, field in section.model_fields.items()}
    fields = fields_of(section)
    values = {names[key]: _value(fields[key].rebuild_annotation(), value) for key, value in written.items() if key in fields}
    return section.model_construct(**values)


def _value(annotation: Any, written: Any) -> Any:
    inner = bare(annotation)
    if isinstance(inner, type) and issubclass(inner, Section) and isinstance(written, dict):
        return _section(inner, written)
    if get_origin(inner) is dict and isinstance(written, dict):
        return {key: _value(get_args(inner)[1], value) for key, value in written.items()}
    try:
        return TypeAdapter(annotation).validate_python(written)
    except ValidationError:
        return written
