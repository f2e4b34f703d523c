"""The effects that may be missing on a rig: every kind at every place that can have it and does not have it yet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from config.schema.effect import Effect, Search, Sizes
from config.schema.effect_entry import EffectEntry, HydraulicEntry, unit_at
from config.schema.effect_library import EFFECTS
from config.schema.plant import Plant
from config.schema.plant_joint import Crosshead, PlantJoint
from config.schema.rig import Rig
from config.signal_names import signal_measures
from gap.fitting.model import Free
from gap.suspects.sizes import sizes_of


@dataclass(frozen=True, slots=True)
class Candidate:
    """One effect at one place. `entry` is neutral; `starts` are values of `free` from which to fit."""

    effect: str
    where: str
    equation: str
    entry: EffectEntry
    free: tuple[Free, ...]
    starts: tuple[tuple[float, ...], ...]
    smaller_is_weaker: bool = True  # a smaller first parameter is a smaller effect

    @property
    def label(self) -> str:
        return f"{self.effect} at {self.where}"


def candidates(rig: Rig, channels: frozenset[str]) -> list[Candidate]:
    """Every effect at every place of the rig that its file does not have yet; sensor effects only for the channels compared."""
    plant = rig.plant
    assert plant is not None
    present = {(entry.effect, entry.where) for entry in plant.effects}
    found = []
    for effect in EFFECTS.values():
        search = effect.search
        if search is None:
            continue  # no physics, so nothing to find
        for where, kind in _places(effect, search, plant, rig, channels):
            beside = frozenset(name for name, place in present if place == where)
            if (effect.name, where) not in present and search.beside in ("", *beside):
                candidate = _candidate(effect, search, where, kind, sizes_of(rig, plant, where), beside)
                found += [candidate] if candidate.free or search.fixed else []
    return found


def _candidate(effect: Effect, search: Search, where: str, kind: str, sizes: Sizes, beside: frozenset[str]) -> Candidate:
    given: dict[str, object] = {"effect": effect.name, "where": where, "quantity_kind": kind}
    given |= {key: value(sizes) for key, value in search.fixed.items()}
    free, starts, fields = [], [], effect.fields
    for freedom in search.free:
        if freedom.beside not in ("", *beside):
            continue
        key, name = freedom.parameter, fields[freedom.parameter]
        typical, calm = freedom.typical(sizes), effect.neutral.get(key, 0.0)
        values = tuple(calm + share * typical for share in freedom.starts)
        rest = effect.neutral[key] if key in effect.neutral else values[0]
        given[key] = rest
        unit = unit_at(effect.entry.model_fields[name], kind) or ""
        free.append(Free((name,), key, unit, rest, abs(typical), freedom.low(sizes), freedom.high(sizes), False))
        starts.append(values)
    entry = effect.entry.model_validate(given)
    return Candidate(effect.name, where, search.equation, entry, tuple(free), _combined(starts), search.smaller_is_weaker)


def _combined(starts: Sequence[tuple[float, ...]]) -> tuple[tuple[float, ...], ...]:
    """Starting points: every start of the parameter with most of them, the others at their first; asymmetric pairs also crossed."""
    if not starts:
        return ((),)
    longest = max(range(len(starts)), key=lambda k: len(starts[k]))
    return tuple(tuple(value if k == longest else other[0] for k, other in enumerate(starts)) for value in starts[longest])


def _places(effect: Effect, search: Search, plant: Plant, rig: Rig, channels: frozenset[str]) -> Iterator[tuple[str, str]]:
    """Where this effect can be, with what the place measures (which decides units)."""
    motions, kinds = {name: joint.motion for name, joint in plant.joints.items()}, effect.entry.kinds
    if "supply" in kinds and plant.supply is not None:
        yield "supply", ""
    if "link" in kinds and rig.arm.kind == "rotary_prismatic":
        yield "link", ""
    for number, (name, joint) in enumerate(plant.joints.items()):
        if joint.motion in kinds and _acts(effect, search, joint) and not (number and effect.is_of_the_whole_plant):
            yield name, joint.motion
    measures = signal_measures(motions)
    for signal in plant.sensors:
        if signal in channels and measures[signal] in kinds and not signal.endswith(search.except_at):
            yield f"sensor:{signal}", measures[signal]


def _acts(effect: Effect, search: Search, joint: PlantJoint) -> bool:
    if isinstance(joint, Crosshead):
        return joint.area_m2 > 0 and search.at_held_rod
    return not joint.is_imposed and (joint.is_hydraulic or not issubclass(effect.entry, HydraulicEntry))
