"""Explanations by name: the rig file with a missing effect put in, or without one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from config.errors import ConfigError
from config.loading.load import LoadedRig
from config.parsing.nearest import nearest
from config.schema.effect_library import EFFECTS
from config.schema.rig import Rig
from gap.fitting.model import Model
from gap.fitting.nuisance import nuisances
from gap.maneuvers.separation import Rival
from gap.suspects.candidates import Candidate, candidates

NONE = "no missing effect"
MOST_RIVALS = 4  # explanations between which a maneuver is sought: every pair costs two comparisons a maneuver


def rival_of(
    loaded: LoadedRig,
    effect: str,
    where: str,
    parameters: Mapping[str, float] | None = None,
    base: Rival | None = None,
) -> Rival:
    """An explanation with one more effect at given parameters, or at its typical size. ConfigError when the rig has no place for it.

    `base`: what it is added to (default: the rig file as it is).
    """
    before = (base or no_effect(loaded)).model
    possible = addable(before.rig)
    chosen = next((c for c in possible if (c.effect, c.where) == (effect, where)), None)
    if chosen is None:
        raise _cannot_be_added(loaded.path, before.rig, effect, where, possible)
    model = before.with_effect(chosen.entry, chosen.free)
    values = [(parameters or {}).get(free.key, start) for free, start in zip(chosen.free, chosen.starts[0], strict=True)]
    return Rival(chosen.label, model.with_theta(np.concatenate([before.theta, values])))


def addable(rig: Rig) -> list[Candidate]:
    """Every effect at every place that the rig file lacks."""
    assert rig.plant is not None
    return candidates(rig, frozenset(rig.plant.sensors))


def _cannot_be_added(path: str, rig: Rig, effect: str, where: str, possible: Sequence[Candidate]) -> ConfigError:
    assert rig.plant is not None
    name, places = f"{effect}@{where}", [c.where for c in possible if c.effect == effect]
    if any((entry.effect, entry.where) == (effect, where) for entry in rig.plant.effects):
        advice = "Take its line out of a copy of the file, or name an effect that the file lacks."
        return ConfigError("the rig file has this effect already", value=name, where=path, next_step=advice)
    if places:
        likely = nearest(where, places, alike=0.0) or places[0]
        advice = f"Possible: {', '.join(f'{effect}@{place}' for place in places)}."
        return ConfigError("the effect has no such place here", value=name, where=path, next_step=advice, mend={name: f"{effect}@{likely}"})
    search = EFFECTS[effect].search if effect in EFFECTS else None
    if search and search.beside:
        advice = f"Add {search.beside} at {where} to a copy of the rig file first."
        return ConfigError(f"{effect} is looked for only where the file has {search.beside}", value=name, where=path, next_step=advice)
    effects = sorted({c.effect for c in possible})
    near = nearest(effect, effects)
    advice = f"{f'Nearest is {near}. ' if near else ''}Possible: {', '.join(effects)}."
    return ConfigError("no such effect can be missing here", value=name, where=path, next_step=advice)


def no_effect(loaded: LoadedRig, constants: Mapping[str, float] | None = None) -> Rival:
    """The rig file without a further effect, its constants free. `constants`: refitted values of them, by their key."""
    assert loaded.rig.plant is not None
    free = nuisances(loaded, frozenset(loaded.rig.plant.sensors))
    return Rival(NONE, Model(loaded.rig, free, np.array([(constants or {}).get(item.key, item.start) for item in free])))
