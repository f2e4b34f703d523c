"""What every entry of `plant.effects` is: `{effect: NAME, where: PLACE, …parameters}`, and parameters whose unit follows from the place.

An effect's file derives its entry from the class of the place it belongs to; `effect.Effect` takes that class.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

from annotated_types import Ge
from pydantic import Field, ValidationInfo, field_validator
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from config.errors import UnitError
from config.schema.plant_joint import PlantJoint
from config.schema.section import Section, unit_of
from config.units import to_si

ROTARY, LINEAR = "rotary", "linear"

# Units of what an effect's parameters measure, by the place: forces and masses of a rotary joint are torques and inertias.
FORCE = {ROTARY: "N*m", LINEAR: "N"}
VELOCITY = {ROTARY: "rad/s", LINEAR: "m/s"}
DAMPING = {ROTARY: "N*m*s/rad", LINEAR: "N*s/m"}
STIFFNESS = {ROTARY: "N*m/rad", LINEAR: "N/m"}
MASS = {ROTARY: "kg*m^2", LINEAR: "kg"}
LENGTH = {ROTARY: "rad", LINEAR: "m"}
FORCE_PER_PRESSURE = {ROTARY: "N*m/Pa", LINEAR: "N/Pa"}
READING = {"angle": "rad", "length": "m", "pressure": "Pa", "temperature": "K", "acceleration": "m/s^2"}


class PlacedSection(Section):
    """A section whose place in the file (a joint, a signal) decides the unit of some of its keys.

    `quantity_kind` is filled in by the plant section: "rotary" or "linear" for a joint, "angle", "pressure", … for a signal.
    """

    quantity_kind: str = Field("", description="inferred from the place", json_schema_extra={"inferred": True})

    @field_validator("*", mode="before")
    @classmethod
    def _convert_units(cls, value: Any, info: ValidationInfo) -> Any:
        field = cls.model_fields[str(info.field_name)]
        kind = str(info.data.get("quantity_kind", ""))
        unit = unit_at(field, kind)
        if unit is None and kind and _depends_on_place(field):
            # The place is the mistake, and `where` says so; the number cannot be judged.
            return [] if isinstance(value, (list, tuple)) else _smallest(field)
        if unit is None or value is None:
            return value
        try:
            return [to_si(item, unit) for item in value] if isinstance(value, (list, tuple)) else to_si(value, unit)
        except UnitError as error:
            raise PydanticCustomError("unit", "{what}", {"what": error.refusal.what, "next_step": error.refusal.next_step}) from error


class EffectEntry(PlacedSection):
    """One physical effect at one place. A plant without the entry behaves exactly as if the effect did not exist."""

    place: ClassVar[str]  # what the effect belongs to, for messages
    kinds: ClassVar[frozenset[str]]  # the quantity_kind of places it can be at
    effect: str
    where: str

    def obstacles(self, joint: PlantJoint) -> Iterator[str]:
        """Why the effect can do nothing at this joint, each as the end of a sentence ("needs …"); asked for entries at a joint only."""
        yield from ()

    def warnings(self) -> Iterator[str]:
        """What `longreach check` should warn of, each a whole sentence without the full stop."""
        yield from ()

    @field_validator("where")
    @classmethod
    def _place_fits(cls, where: str, info: ValidationInfo) -> str:
        kind = info.data.get("quantity_kind", "")
        if kind and kind not in cls.kinds:
            raise ValueError(f"this effect belongs at {cls.place}")
        return where


class JointEntry(EffectEntry):
    place = "a joint"
    kinds = frozenset({ROTARY, LINEAR})


class HydraulicEntry(JointEntry):
    """At a joint that oil moves. (The other effects of a valve exist in an electric drive too.)"""

    def obstacles(self, joint: PlantJoint) -> Iterator[str]:
        if not joint.is_hydraulic:
            yield "needs a hydraulic actuator there"


class SupplyEntry(EffectEntry):
    place = "'supply'"
    kinds = frozenset({"supply"})


class LinkEntry(EffectEntry):
    place = "'link'"
    kinds = frozenset({"link"})


class SensorEntry(EffectEntry):
    place = "a sensor, written sensor:SIGNAL"
    kinds = frozenset(READING)


def quantity_by_place(
    units: Mapping[str, str], description: str, default: Any = ..., *, low: float | None = None, high: float | None = None
) -> Any:
    """Declare a number whose unit depends on the place: `quantity_by_place({"rotary": "N*m", "linear": "N"}, "...")`."""
    written = " or ".join(dict.fromkeys(units.values()))
    return Field(default, ge=low, le=high, description=f"{description} [{written}]", json_schema_extra={"unit_by_place": dict(units)})


def unit_at(field: FieldInfo, quantity_kind: str) -> str | None:
    """The unit of a field at a place of this kind; None for a field that is no quantity (or a place that does not exist)."""
    extra = field.json_schema_extra
    if _depends_on_place(field) and isinstance(extra, dict):
        units = extra["unit_by_place"]
        return str(units[quantity_kind]) if isinstance(units, dict) and quantity_kind in units else None
    return unit_of(field)


def _depends_on_place(field: FieldInfo) -> bool:
    return isinstance(field.json_schema_extra, dict) and "unit_by_place" in field.json_schema_extra


def _smallest(field: FieldInfo) -> float:
    return next((float(extra.ge) for extra in field.metadata if isinstance(extra, Ge)), 0.0)  # type: ignore[arg-type]
