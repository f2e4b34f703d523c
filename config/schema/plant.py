"""The `plant:` section of a rig file: the simulated rig. Everything here is the ideal machine; what is not ideal is in `effects`.

Ideal means: masses, areas and volumes, a four-land valve that follows its command, a constant supply, oil of constant stiffness,
a rigid link. Friction, lags, leakage, air, hoses, flexibility, droop, … are entries of `effects`, each of which can be deleted.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, Tag, ValidationInfo, field_validator, model_validator

from config.oil_grades import GRADES, walther_constants
from config.schema.effect_entry import EffectEntry
from config.schema.effect_library import EFFECTS, PROBLEMS
from config.schema.plant_joint import AnyPlantJoint, motion_of
from config.schema.plant_sensor import Sensor
from config.schema.section import Section, chosen_by, quantity
from config.signal_names import signal_measures


def _any_effect() -> Any:
    sections = {name: effect.entry for name, effect in EFFECTS.items()}
    members = [Annotated[section, Tag(name)] for name, section in sections.items()]
    if len(members) < 2:
        return members[0] if members else EffectEntry  # no library was loaded: `_libraries_loaded` refuses every entry
    return Annotated[reduce(or_, members), chosen_by("effect")]


if TYPE_CHECKING:
    AnyEffect = EffectEntry
else:
    AnyEffect = _any_effect()


class Oil(Section):
    """The fluid. Viscosity by Walther's law log10 log10(nu + 0.7) = A - B log10 T (nu in cSt, T in K), from a data sheet's ISO VG grade
    or from A and B."""

    density_kg_per_m3: float = quantity("kg/m^3", "at 40 degC", low=500, high=2000)
    specific_heat_J_per_kg_K: float = quantity("J/kg/K", "", low=500, high=10000)
    bulk_modulus_Pa: float = quantity("Pa", "of the liquid at 40 degC and no pressure", low=1e7, high=1e10)
    bulk_modulus_pressure_slope: float = quantity("", "rise of the bulk modulus per pressure", 0.0, low=0, high=20)
    vapour_pressure_Pa: float = quantity("Pa", "absolute; a chamber's pressure never falls below it", 1e4, low=0, high=1e5)
    iso_vg: int | None = Field(default=None, description="grade of a mineral oil of viscosity index 100, in place of the next two")
    walther_a: float = quantity("", "A of Walther's law", low=1, high=30)
    walther_b: float = quantity("", "B of Walther's law", low=0.1, high=12)
    initial_temperature_C: float = quantity("degC", "of oil and metal at the start", 40.0, low=-20, high=90)

    @model_validator(mode="before")
    @classmethod
    def _by_grade(cls, content: Any) -> Any:
        """Walther's constants of the grade."""
        if not isinstance(content, dict) or content.get("iso_vg") is None:
            return content
        twice = [key for key in ("walther_a", "walther_b") if key in content]
        if twice:
            raise ValueError(f"iso_vg stands in place of {' and '.join(twice)}: give the grade or the constants")
        grade = content["iso_vg"]
        if not isinstance(grade, (int, float)) or grade not in GRADES:
            raise ValueError(f"iso_vg {grade!r} is none of {', '.join(map(str, GRADES))}; give walther_a and walther_b instead")
        a, b = walther_constants(float(grade), GRADES[int(grade)])
        return {**content, "walther_a": a, "walther_b": b}


class Supply(Section):
    """An ideal supply: constant pressures at every valve (gauge)."""

    pressure_Pa: float = quantity("Pa", "supply pressure", low=1e4, high=50e6)
    return_pressure_Pa: float = quantity("Pa", "return pressure", 0.0, low=0, high=5e6)


class Thermal(Section):
    """Reservoir, supply hose and valve/actuator metal as three heat stores; without this section the temperature is constant."""

    ambient_C: float = quantity("degC", "room", 22.0, low=-40, high=60)
    reservoir_capacity_J_per_K: float = quantity("J/K", "oil and tank", low=1, high=1e9)
    reservoir_loss_W_per_K: float = quantity("W/K", "tank to room", low=0, high=1e5)
    hose_capacity_J_per_K: float = quantity("J/K", "wall of the supply hose", low=1, high=1e8)
    hose_inside_W_per_K: float = quantity("W/K", "oil to hose wall", low=0, high=1e5)
    hose_outside_W_per_K: float = quantity("W/K", "hose wall to room", low=0, high=1e5)
    metal_capacity_J_per_K: float = quantity("J/K", "valves and actuators", low=1, high=1e8)
    metal_inside_W_per_K: float = quantity("W/K", "oil to metal", low=0, high=1e5)
    metal_outside_W_per_K: float = quantity("W/K", "metal to room", low=0, high=1e5)
    metal_share: float = quantity("", "share of the throttling heat that goes into the metal", low=0, high=1)
    pump_flow_m3_per_s: float = quantity("m^3/s", "pump flow that returns to the tank when the valves do not take it", low=0, high=1)
    bypass_share: float = quantity("", "share of the supply pressure at which it returns", low=0, high=1)
    pump_loss_W: float = quantity("W", "constant loss of pump and motor into the oil", low=0, high=1e6)


class Link(Section):
    """The prismatic link: a uniform tube that slides out of the hub, payload at its tip. Rigid without `link_flexibility`."""

    mass_per_length_kg_per_m: float = quantity("kg/m", "rho A", low=0, high=500)
    total_length_m: float = quantity("m", "whole tube, extended and retracted part", low=0.01, high=50)
    hub_inertia_kg_m2: float = quantity("kg*m^2", "everything that turns and does not slide", low=1e-6, high=1e6)
    carriage_kg: float = quantity("kg", "rod, piston and carriage that slide with the tube", low=0, high=1e5)
    payload_kg: float = quantity("kg", "at the tip", 0.0, low=0, high=1e4)
    payload_inertia_kg_m2: float = quantity("kg*m^2", "of the payload about the tip", 0.0, low=0, high=1e4)


class Plant(Section):
    """The simulated rig."""

    step_s: float = quantity("s", "largest integration step; every control period is cut into equal steps", 2.5e-4, low=1e-6, high=1e-3)
    joints: dict[str, AnyPlantJoint] = Field(min_length=1, max_length=2)
    oil: Oil | None = None
    supply: Supply | None = None
    thermal: Thermal | None = None
    link: Link | None = None
    sensors: dict[str, Sensor]
    effects: tuple[AnyEffect, ...] = ()

    @model_validator(mode="before")
    @classmethod
    def _fill_in_places(cls, content: Any) -> Any:
        """Tell every effect and sensor what its place measures, because the units follow from it."""
        if not isinstance(content, dict):
            return content
        motions = {name: motion_of(joint) for name, joint in _items(content.get("joints")) if isinstance(joint, dict)}
        kinds = {"supply": "supply", "link": "link"} | motions | {f"sensor:{name}": kind for name, kind in signal_measures(motions).items()}
        filled = dict(content)
        if isinstance(content.get("effects"), list):
            filled["effects"] = [_with_kind(entry, kinds.get(_where(entry), "")) for entry in content["effects"]]
        if isinstance(content.get("sensors"), dict):
            filled["sensors"] = {name: _with_kind(entry, kinds.get(f"sensor:{name}", "")) for name, entry in content["sensors"].items()}
        return filled

    @field_validator("effects", mode="before")
    @classmethod
    def _libraries_loaded(cls, entries: Any) -> Any:
        """An effect may be unknown because its library cannot be loaded: then that is what is wrong."""
        named = {str(entry.get("effect")) for entry in entries if isinstance(entry, dict)} if isinstance(entries, list) else set()
        if PROBLEMS and (unknown := sorted(named - EFFECTS.keys())):
            raise ValueError(f"{', '.join(unknown)}: {'; '.join(PROBLEMS)}")
        return entries

    @field_validator("effects")
    @classmethod
    def _places_exist(cls, effects: tuple[EffectEntry, ...], info: ValidationInfo) -> tuple[EffectEntry, ...]:
        if "joints" not in info.data or "sensors" not in info.data:
            return effects  # their own problems come first
        problems = list(_wrong_places(effects, info.data))
        if problems:
            raise ValueError("; ".join(problems))
        return effects


def _wrong_places(effects: tuple[EffectEntry, ...], plant: dict[str, Any]) -> Iterator[str]:
    """Effects at a place that exists but has nothing for them to act on, and effects listed twice."""
    seen: set[tuple[str, str]] = set()
    for index, entry in enumerate(effects):
        label = f"entry {index} ({entry.effect} at {entry.where})"
        joint = plant["joints"].get(entry.where)
        if joint:
            yield from (f"{label} {what}" for what in entry.obstacles(joint))
        if entry.where in ("supply", "link") and plant.get(entry.where, ...) is None:  # one with a problem of its own is not in `plant`
            yield f"{label} needs the section plant.{entry.where}"
        acts_on = "the whole plant" if EFFECTS[entry.effect].is_of_the_whole_plant else entry.where
        if (entry.effect, acts_on) in seen:
            yield f"{label} is there twice" + ("" if acts_on == entry.where else ": it acts on the whole plant, so one entry says all")
        seen.add((entry.effect, acts_on))


def _with_kind(entry: Any, kind: str) -> Any:
    return {**entry, "quantity_kind": kind} if isinstance(entry, dict) else entry


def _where(entry: Any) -> str:
    return str(entry.get("where", "")) if isinstance(entry, dict) else ""


def _items(section: Any) -> Any:
    return section.items() if isinstance(section, dict) else ()
