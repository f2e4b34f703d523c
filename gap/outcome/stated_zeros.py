"""Constants that the rig file states as 0 and that the logs want elsewhere: said before any name, since a wrong name may do their work.

A name that gives the simulation the same number is told as that constant. Where names stay open, each is also left free beside constants
alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from config.loading.load import LoadedRig
from config.parsing.yaml_tree import YamlTree, parse
from config.progress import Progress
from config.schema.section import yaml_key
from gap.fitting.evaluation import mean_cost
from gap.fitting.model import Free, Model
from gap.fitting.nuisance import held
from gap.outcome.held_constants import HeldConstant, wanted
from gap.outcome.names import Named, numbers_of
from gap.outcome.search_state import SearchState

ALONE = "constants alone"


def stated_zeros(loaded: LoadedRig, state: SearchState, told: Sequence[dict[str, Any]], progress: Progress) -> list[HeldConstant]:
    """`told`: findings and leads."""
    tree = parse(loaded.text, loaded.path)
    stated = {free.key: (free, line) for free in held(loaded, state.channels) if free.start == 0.0 and (line := _line(tree, free))}
    named = [item for free, line in stated.values() for name in state.named if (item := _named(free, line, state, name, told))]
    if not state.named or all(item["confirmed"] for item in told):
        return named
    left = [free for free, _ in stated.values() if free.key not in {item.free.key for item in named}]
    alone = wanted(left, state.without_names, progress) if left else []
    return [*named, *(replace(item, beside=ALONE, line=stated[item.free.key][1]) for item in alone)]


def _line(tree: YamlTree, free: Free) -> int | None:
    """Where the file itself has the number; None where it stands at its default."""
    at = ("plant", *(yaml_key(part) if isinstance(part, str) else part for part in free.path))
    return tree.mark(at)[0] if tree.value(at) is not None else None


def _named(free: Free, line: int, state: SearchState, name: Named, told: Sequence[dict[str, Any]]) -> HeldConstant | None:
    """The constant as the name has it, where one of the effect's parameters is the same number."""
    model, place = state.current.model, (name.suspect.effect, name.suspect.where)
    item = next((one for one in told if (one["effect"], one["where"]) == place), None)
    same = next((model.free[k] for k in numbers_of(name.suspect, model) if _is_the_same(free, model, k)), None)
    if item is None or same is None:
        return None
    size = item["parameters"][same.key.rpartition(".")[2]]
    before, after = mean_cost(name.explanation.without), mean_cost(name.explanation.holdout)
    half_width = 0.5 * (size["ci95"][1] - size["ci95"][0])
    return HeldConstant(free, size["value"], half_width, before, after, f"{place[0]} at {place[1]}", line)


def _is_the_same(free: Free, model: Model, number: int) -> bool:
    """Whether the constant and a parameter of an effect change the simulation's numbers alike."""
    value, theta = float(model.theta[number]), model.theta.copy()
    theta[number] = 0.0
    alone = model.with_theta(theta)
    moved = replace(alone, free=(*alone.free, free), theta=np.append(theta, value))
    return value != 0.0 and bool(np.allclose(moved.vector(), model.vector(), rtol=1e-9, atol=0.0))
