"""Where a candidate is first tried: models with it at its starting points and at its typical sizes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from config.schema.effect_library import EFFECTS
from gap.fitting.model import Model
from gap.suspects.candidates import Candidate


def points(candidate: Candidate, model: Model) -> list[Model]:
    """Models with the candidate in it: every starting point, and every parameter that has a neutral value alone at its typical size."""
    grown = model.with_effect(candidate.entry, candidate.free)
    return [placed(grown, values) for values in [*candidate.starts, *_alone(candidate)]]


def placed(grown: Model, values: Sequence[float]) -> Model:
    """The model with these values of its last effect's parameters, within their ranges."""
    numbers = grown.of_effect(grown.added[-1])
    theta = grown.theta.copy()
    theta[numbers] = np.clip(values, [grown.free[k].low for k in numbers], [grown.free[k].high for k in numbers])
    return grown.with_theta(theta)


def _alone(candidate: Candidate) -> list[tuple[float, ...]]:
    """One parameter at its typical size, the others at rest; only where there are several to tell apart."""
    if sum(free.key in EFFECTS[candidate.effect].neutral for free in candidate.free) < 2:
        return []
    rest = [free.start for free in candidate.free]
    return [
        tuple(value + (free.scale if j == k else 0.0) for j, (free, value) in enumerate(zip(candidate.free, rest, strict=True)))
        for k, free in enumerate(candidate.free)
    ]
