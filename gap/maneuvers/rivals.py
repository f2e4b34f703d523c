"""Explanations by name: the rig file with a missing effect put in, or without one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from config.errors import ConfigError
from config.loading.load import LoadedRig
from gap.fitting.model import Model
from gap.fitting.nuisance import nuisances
from gap.maneuvers.separation import Rival
from gap.suspects.candidates import candidates

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
    assert loaded.rig.plant is not None
    possible = candidates(before.rig, frozenset(loaded.rig.plant.sensors))
    chosen = next((c for c in possible if (c.effect, c.where) == (effect, where)), None)
    if chosen is None:
        advice = f"Possible: {', '.join(sorted({c.label for c in possible}))}."
        raise ConfigError("this effect cannot be added to the rig", value=f"{effect} at {where}", where=loaded.path, next_step=advice)
    model = before.with_effect(chosen.entry, chosen.free)
    values = [(parameters or {}).get(free.key, start) for free, start in zip(chosen.free, chosen.starts[0], strict=True)]
    return Rival(chosen.label, model.with_theta(np.concatenate([before.theta, values])))


def no_effect(loaded: LoadedRig, constants: Mapping[str, float] | None = None) -> Rival:
    """The rig file without a further effect, its constants free. `constants`: refitted values of them, by their key."""
    assert loaded.rig.plant is not None
    free = nuisances(loaded, frozenset(loaded.rig.plant.sensors))
    return Rival(NONE, Model(loaded.rig, free, np.array([(constants or {}).get(item.key, item.start) for item in free])))
