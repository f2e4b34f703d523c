"""Suspects that the rig file has already, but with another size: worn, leaking, dirty, lost.

Every size of an entry of `plant.effects`, and every constant that a fault changes and no effect of the library stands for. Its narrow prior
is replaced by the wide one that the same effect would have if it were missing; all else is as for a missing effect.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from config.schema.effect_library import EFFECTS
from config.schema.plant import Plant
from config.schema.rig import Rig
from gap.evidence.deciding_numbers import CHANGED_TIMES
from gap.fitting.model import Free, Model
from gap.suspects.sizes import sizes_of

# Rated flow: an orifice that is worn or clogged. Null, payload and mass have effects of their own, which would be the same twice.
_OF_FAULTS = {"rated_flow_m3_per_s": "rated_flow"}


@dataclass(frozen=True, slots=True)
class Changed:
    """A number of the rig file suspected of another value. `free`: with the wide prior; `effect`, `where`: as in the file, or the name of
    the constant and its joint."""

    effect: str
    where: str
    free: Free

    @property
    def label(self) -> str:
        return f"{self.effect} at {self.where} changed ({self.free.key.rpartition('.')[2]})"

    def number_in(self, model: Model) -> int:
        """Which of the model's numbers it is."""
        return next(k for k, f in enumerate(model.free) if f.key == self.free.key)

    def value_in(self, model: Model) -> float:
        """What a model has for the number."""
        return float(model.theta[self.number_in(model)])

    def with_value(self, model: Model, value: float) -> Model:
        """The model with another value of the number."""
        theta = model.theta.copy()
        theta[self.number_in(model)] = value
        return model.with_theta(theta)

    def with_wide_prior(self, model: Model) -> Model:
        """The model with this number's prior widened."""
        return replace(model, free=tuple(self.free if f.key == self.free.key else f for f in model.free))

    def with_own_prior(self, model: Model, stated: Model) -> Model:
        """The model with this number's prior as in the rig file (`stated`) again, and its value within what that allows."""
        own = next(f for f in stated.free if f.key == self.free.key)
        free = tuple(own if f.key == own.key else f for f in model.free)
        theta = [np.clip(v, f.low, f.high) if f is own else v for f, v in zip(free, model.theta, strict=True)]
        return replace(model, free=free, theta=np.array(theta))


def changeable(rig: Rig, free: tuple[Free, ...]) -> list[Changed]:
    """Every such number among the free constants of a rig."""
    plant = rig.plant
    assert plant is not None
    return list(_of_entries(rig, plant, free)) + [c for f in free if (c := _of_constant(f)) is not None]


def _of_entries(rig: Rig, plant: Plant, free: tuple[Free, ...]) -> Iterator[Changed]:
    for number, entry in enumerate(plant.effects):
        search = EFFECTS[entry.effect].search
        for freedom in search.free if search else ():
            named = (f for f in free if f.path[:2] == ("effects", number))
            own = next((f for f in named if f.key.rpartition(".")[2] == freedom.parameter), None)
            if own is None or own.key.rpartition(".")[2] not in EFFECTS[entry.effect].neutral:
                continue
            sizes = sizes_of(rig, plant, entry.where)
            low, high = sorted((freedom.low(sizes), freedom.high(sizes)))
            yield Changed(entry.effect, entry.where, _wide(own, min(low, own.start), max(high, own.start)))


def _of_constant(free: Free) -> Changed | None:
    name = _OF_FAULTS.get(str(free.path[-1]))
    if name is None or free.path[0] != "joints":
        return None
    return Changed(name, str(free.path[1]), _wide(free, free.start / CHANGED_TIMES, free.start * CHANGED_TIMES))


def _wide(free: Free, low: float, high: float) -> Free:
    return replace(free, low=low, high=high, prior=False)
