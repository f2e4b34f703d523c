"""A plant model with free numbers: the rig, which of its constants may move, and their present values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from config.schema.effect_entry import EffectEntry
from config.schema.plant import Plant
from config.schema.rig import Rig
from gap.data.measured import Array
from sim_backend.kernel.batch import quiet
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import Vector

Path = tuple[str | int, ...]


@dataclass(frozen=True, slots=True)
class Free:
    """One number of the plant section that a fit may move, by its path in the model (`("link", "payload_kg")`).

    `scale` is the unit of the fit's own coordinates: the prior's standard deviation of a constant, a typical size of an effect's parameter.
    `prior` says whether moving away from `start` costs.
    """

    path: Path
    key: str  # as in the rig file: plant.link.payload
    unit: str
    start: float
    scale: float
    low: float
    high: float
    prior: bool
    tag: str = ""


@dataclass(frozen=True, slots=True)
class Model:
    """The rig's plant with the values `theta` for the numbers `free`; `added` are the effects put in by the search, in its order."""

    rig: Rig
    free: tuple[Free, ...]
    theta: Array
    added: tuple[EffectEntry, ...] = field(default=())

    def plant(self, theta: Array | None = None) -> Plant:
        values = self.theta if theta is None else theta
        assert self.rig.plant is not None
        changed: Plant = with_values(self.rig.plant, {free.path: float(value) for free, value in zip(self.free, values, strict=True)})
        return changed

    def vector(self, theta: Array | None = None) -> Vector:
        """The kernel's parameter vector for `theta` (default: the model's own), with quiet sensors."""
        return quiet(Parameters(self.rig.model_copy(update={"plant": self.plant(theta)})))

    def fitted_rig(self) -> Rig:
        """The rig with the present values in its plant."""
        return self.rig.model_copy(update={"plant": self.plant()})

    def with_theta(self, theta: Array) -> Model:
        return replace(self, theta=theta)

    def with_own_constants(self) -> Model:
        """Every constant as in the rig file; what has no prior, the effects' parameters, keeps its value."""
        return self.with_theta(np.array([f.start if f.prior else value for f, value in zip(self.free, self.theta, strict=True)]))

    def with_effect(self, entry: EffectEntry, free: Sequence[Free]) -> Model:
        """The model with one more effect at the end of its list; paths of `free` are relative to the entry."""
        assert self.rig.plant is not None
        number = len(self.rig.plant.effects)
        plant = self.rig.plant.model_copy(update={"effects": (*self.rig.plant.effects, entry)})
        places = tuple(replace(item, path=("effects", number, *item.path)) for item in free)
        theta = np.concatenate([self.theta, [item.start for item in free]])
        rig = self.rig.model_copy(update={"plant": plant})
        return Model(rig, self.free + places, theta, (*self.added, entry))

    def without_effect(self, entry: EffectEntry) -> Model:
        """The model without one of the effects the search had added."""
        assert self.rig.plant is not None
        effects = self.rig.plant.effects
        gone = next(number for number, other in enumerate(effects) if other is entry)
        keep = [k for k, free in enumerate(self.free) if free.path[:2] != ("effects", gone)]
        plant = self.rig.plant.model_copy(update={"effects": effects[:gone] + effects[gone + 1 :]})
        free = tuple(_shifted(self.free[k], gone) for k in keep)
        added = tuple(other for other in self.added if other is not entry)
        return Model(self.rig.model_copy(update={"plant": plant}), free, self.theta[keep], added)

    def restricted(self, numbers: Sequence[int]) -> Model:
        """The model in which only these numbers are free; all others stand as in the rig file."""
        return replace(self, free=tuple(self.free[k] for k in numbers), theta=self.theta[list(numbers)])

    def entry_added(self, effect: str, where: str) -> EffectEntry:
        """An effect that the search had added, as it stands there."""
        return next(entry for entry in self.added if (entry.effect, entry.where) == (effect, where))

    def of_effect(self, entry: EffectEntry) -> list[int]:
        """Numbers of the free parameters that belong to an added effect."""
        assert self.rig.plant is not None
        number = next(k for k, other in enumerate(self.rig.plant.effects) if other is entry)
        return [k for k, free in enumerate(self.free) if free.path[:2] == ("effects", number)]

    @property
    def scales(self) -> Array:
        return np.array([free.scale for free in self.free])

    @property
    def pulls(self) -> Array:
        """How far every constant with a prior stands from its start, in prior standard deviations (0 for the others)."""
        return np.array([(value - f.start) / f.scale if f.prior else 0.0 for f, value in zip(self.free, self.theta, strict=True)])


def _shifted(free: Free, gone: int) -> Free:
    path = free.path
    if path[0] == "effects" and isinstance(path[1], int) and path[1] > gone:
        return replace(free, path=("effects", path[1] - 1, *path[2:]))
    return free


def with_values(node: Any, values: Mapping[Path, float]) -> Any:
    """A copy of a configuration section with new values at some paths. Ranges are the caller's business."""
    groups: dict[str | int, dict[Path, float]] = {}
    for path, value in values.items():
        if not path:
            return value
        groups.setdefault(path[0], {})[path[1:]] = value
    if not groups:
        return node
    if isinstance(node, tuple):
        return tuple(with_values(item, groups[k]) if k in groups else item for k, item in enumerate(node))
    if isinstance(node, dict):
        return {key: with_values(item, groups[key]) if key in groups else item for key, item in node.items()}
    return node.model_copy(update={str(key): with_values(getattr(node, str(key)), inner) for key, inner in groups.items()})
