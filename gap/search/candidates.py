"""The effects that may be missing on a rig: every kind at every place that can have it and does not have it yet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from config.effect_entry import EffectEntry, unit_at
from config.plant import EFFECT_SECTIONS, Plant, effect_name
from config.plant_joint import Crosshead
from config.rig import Rig
from config.section import yaml_key
from config.signals import signal_measures
from gap.fitting.model import Free
from gap.search.shapes import FLOW, LINK, SHAPES, SUPPLY
from gap.search.sizes import Sizes, sizes_of
from sim_backend.effects.registry import REGISTRY

RUBBING = ("coulomb_friction", "stiction", "viscous_friction", "asymmetric_friction", "pressure_friction", "inertia_error")
# A difference between the directions needs something to differ: without it, it would be one-sided friction, which no seal has.
_EXCEEDS = {"stiction": "coulomb_friction"}  # breakaway beyond the friction while sliding needs a friction while sliding
_NEEDS = {"friction_difference": "coulomb_friction", "coefficient_difference": "viscous_friction"}


@dataclass(frozen=True, slots=True)
class Candidate:
    """One effect at one place. `entry` is neutral; `starts` are values of `free` from which to fit."""

    effect: str
    where: str
    equation: str
    entry: EffectEntry
    free: tuple[Free, ...]
    starts: tuple[tuple[float, ...], ...]

    @property
    def label(self) -> str:
        return f"{self.effect} at {self.where}"


def candidates(rig: Rig, channels: frozenset[str]) -> list[Candidate]:
    """Every effect at every place of the rig that its file does not have yet; sensor effects only for the channels compared."""
    plant = rig.plant
    assert plant is not None
    present = {(entry.effect, entry.where) for entry in plant.effects}
    found = []
    for section in EFFECT_SECTIONS:
        name = effect_name(section)
        if name not in SHAPES:
            continue  # unnamed_remainder: no physics, so nothing to find
        for where, kind in _places(section, plant, rig, channels):
            possible = name not in _EXCEEDS or (_EXCEEDS[name], where) in present
            if possible and (name, where) not in present:
                beside = frozenset(effect for effect, place in present if place == where)
                found.append(_candidate(name, where, kind, section, sizes_of(rig, plant, where), beside))
    return [candidate for candidate in found if candidate.free or candidate.effect == "sensor_polarity"]


def _candidate(name: str, where: str, kind: str, section: type[EffectEntry], sizes: Sizes, beside: frozenset[str]) -> Candidate:
    shape = SHAPES[name]
    given: dict[str, object] = {"effect": name, "where": where, "quantity_kind": kind}
    given |= {yaml_key(key): value(sizes) for key, value in shape.fixed.items()}
    neutral = REGISTRY[name].neutral
    free, starts = [], []
    for freedom in shape.free:
        if _NEEDS.get(freedom.parameter, "") not in ("", *beside):
            continue
        key, field = yaml_key(freedom.parameter), section.model_fields[freedom.parameter]
        typical, calm = freedom.typical(sizes), neutral.get(key, 0.0)
        values = tuple(calm + share * typical for share in freedom.starts)
        rest = neutral[key] if key in neutral else values[0]
        given[key] = rest
        unit = unit_at(field, kind) or ""
        free.append(Free((freedom.parameter,), key, unit, rest, abs(typical), freedom.low(sizes), freedom.high(sizes), False))
        starts.append(values)
    if name == "sensor_polarity":
        given["sign"] = -1
    return Candidate(name, where, shape.equation, section.model_validate(given), tuple(free), _combined(starts))


def _combined(starts: Sequence[tuple[float, ...]]) -> tuple[tuple[float, ...], ...]:
    """Starting points: every start of the parameter with most of them, the others at their first; asymmetric pairs also crossed."""
    if not starts:
        return ((),)
    longest = max(range(len(starts)), key=lambda k: len(starts[k]))
    return tuple(tuple(value if k == longest else other[0] for k, other in enumerate(starts)) for value in starts[longest])


def _places(section: type[EffectEntry], plant: Plant, rig: Rig, channels: frozenset[str]) -> Iterator[tuple[str, str]]:
    """Where this effect can be, with what the place measures (which decides units)."""
    motions = {name: joint.motion for name, joint in plant.joints.items()}
    for where, kind in [*motions.items(), ("supply", ""), ("link", "")]:
        if _allowed(section, plant, rig, where):
            yield where, kind
    kinds = signal_measures(motions)
    name = effect_name(section)
    for signal in plant.sensors if name.startswith("sensor_") else ():
        if signal in channels and not (name == "sensor_offset" and signal.endswith("supply_pressure")):
            yield f"sensor:{signal}", kinds[signal]


def _allowed(section: type[EffectEntry], plant: Plant, rig: Rig, where: str) -> bool:
    name = effect_name(section)
    if name.startswith("sensor_"):
        return False
    equation = SHAPES[name].equation
    if where == "supply":
        return equation == SUPPLY and plant.supply is not None
    if where == "link":
        arm = rig.arm.kind == "rotary_prismatic"
        return equation == LINK and arm and (name != "link_damping_error" or any(e.effect == "link_flexibility" for e in plant.effects))
    if equation in (SUPPLY, LINK):
        return False
    joint = plant.joints[where]
    if isinstance(joint, Crosshead):
        return joint.area_m2 > 0 and name in RUBBING
    if joint.is_imposed:
        return False
    if name == "gravity":
        return where == next(iter(plant.joints))  # one entry tilts the whole arm
    return joint.is_hydraulic or (equation != FLOW and name not in ("pressure_friction", "valve_flow_asymmetry"))
