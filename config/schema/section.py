"""Base of every section of a configuration file: typed, frozen, and strict about keys.

A stored number carries its unit in the Python name (`supply_pressure_Pa`); in the file the key is the field's word alone
(`supply_pressure: 2000 psi`). `quantity("Pa", ...)` declares such a field: unit, allowed range, description. A number whose
unit depends on the joint (rad or m) has no suffix; its class says which.
"""

from __future__ import annotations

import re
from typing import Any

from pydantic import BaseModel, ConfigDict, Discriminator, Field, ValidationInfo, field_validator
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from config.errors import UnitError
from config.units import to_si

_UNIT = r"(?:_(?:Pa|m[2-6]?|kg|N|rad|s2?|Hz|V|C|W|J|K|bytes))+"
_UNIT_SUFFIX = re.compile(rf"(?:{_UNIT}(?:_per{_UNIT})?|_per{_UNIT})$")


def yaml_key(field_name: str) -> str:
    """`supply_pressure_Pa` → `supply_pressure`, `stiffness_N_per_m` → `stiffness`; names without a unit stay as they are."""
    return _UNIT_SUFFIX.sub("", field_name)


class Section(BaseModel):
    """A mapping in a configuration file. Unknown keys are errors; values never change after loading."""

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        alias_generator=yaml_key,
        validate_default=True,
        protected_namespaces=(),
        defer_build=True,  # most sections are only ever read as parts of a file: they need no validator of their own
    )

    @field_validator("*", mode="before")
    @classmethod
    def _convert_units(cls, value: Any, info: ValidationInfo) -> Any:
        unit = unit_of(cls.model_fields[str(info.field_name)])
        if unit is None or value is None:
            return value
        if isinstance(value, (list, tuple)):
            return [_converted(item, unit, index) for index, item in enumerate(value)]
        return _converted(value, unit)


def _converted(value: Any, unit: str, index: int | None = None) -> float:
    """to_si for pydantic; `index` tells the loader which entry of a list is wrong."""
    try:
        return to_si(value, unit)
    except UnitError as error:
        context = {"what": error.refusal.what, "next_step": error.refusal.next_step, "index": index}
        raise PydanticCustomError("unit", "{what}", context) from error
    except TypeError as error:
        raise PydanticCustomError("unit", "a number with an optional unit was expected", {"index": index}) from error


def quantity(unit: str, description: str, default: Any = ..., *, low: float | None = None, high: float | None = None) -> Any:
    """Declare a number with a unit: `supply_pressure_Pa: float = quantity("Pa", "...", low=0, high=35e6)`.

    `unit` is what is stored (SI, temperatures in degC); `low` and `high` are inclusive limits in that unit.
    """
    return Field(default, ge=low, le=high, description=description, json_schema_extra={"unit": unit})


def against(what: str, other: str, stored: str) -> PydanticCustomError:
    """What a validator raises where the key `other` of the same section forbids the value: the loader shows that one as it is written,
    and as `stored` where the file leaves it out."""
    return PydanticCustomError("against", "{what}", {"what": what, "other": other, "stored": stored})


def inferred(description: str) -> Any:
    """Declare a key that the loader fills in from elsewhere in the file and that a user must not write."""
    return Field(description=description, json_schema_extra={"inferred": True})


def is_inferred(field: FieldInfo) -> bool:
    """Whether the field was declared with inferred()."""
    extra = field.json_schema_extra
    return isinstance(extra, dict) and extra.get("inferred") is True


def unit_of(field: FieldInfo) -> str | None:
    """The unit a field was declared with by quantity(), or None for a field that is no quantity."""
    extra = field.json_schema_extra
    return str(extra["unit"]) if isinstance(extra, dict) and "unit" in extra else None


def units_of(field: FieldInfo) -> tuple[str, ...]:
    """Every unit a field may have: that of quantity(), or those of a field whose unit depends on its place in the file."""
    extra = field.json_schema_extra
    by_place = extra.get("unit_by_place") if isinstance(extra, dict) else None
    if isinstance(by_place, dict):
        return tuple(dict.fromkeys(map(str, by_place.values())))
    unit = unit_of(field)
    return () if unit is None else (unit,)


def chosen_by(key: str) -> Discriminator:
    """Discriminator of a union of sections by the value of `key`; members are `Annotated[Class, Tag("value")]`.

    (pydantic's own string discriminator does not allow the unit conversion above on the same model.)
    """
    return Discriminator(
        lambda value: value.get(key) if isinstance(value, dict) else getattr(value, key, None),
        custom_error_type="choice",
        custom_error_message="{key} must be one of the known words",
        custom_error_context={"key": key},
    )
