"""Two explanations that come from no fit, made as alike as they can be: before that, their distance says little."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from config.errors import LongreachError
from config.load import LoadedRig
from gap.maneuvers.designs import Design
from gap.maneuvers.separation import Comparison, Rival, compare
from gap.search.settings import PROCESSORS

_STEPS = 4
_ENOUGH = 0.99  # ratio of T from which a further step is not worth it


def matched(loaded: LoadedRig, first: Rival, second: Rival, maneuvers: Sequence[Design]) -> Rival:
    """The second with its own parameters fitted to the first, on the first of the maneuvers that both can run; as it is if none can."""
    design = next((d for d in maneuvers if _compared(loaded, first, second, d)), None)
    best, least = second, np.inf
    for _ in range(_STEPS if design else 0):
        comparison = _compared(loaded, first, second, design) if design else None
        if comparison is None or _ENOUGH * least < comparison.bound().T:
            break
        best, least = second, comparison.bound().T
        second = _moved(second, comparison)
    return best


def _compared(loaded: LoadedRig, first: Rival, second: Rival, design: Design) -> Comparison | None:
    try:
        return compare(loaded, first, second, design.content, workers=PROCESSORS)
    except LongreachError:
        return None


def _moved(rival: Rival, comparison: Comparison) -> Rival:
    """One Gauss-Newton step of the second rival's own parameters, inside their ranges."""
    model = rival.model
    numbers = [k for k, free in enumerate(model.free) if not free.prior]
    shift = comparison.step(numbers)
    theta = model.theta.copy()
    for k, move in zip(numbers, shift, strict=True):
        free = model.free[k]
        theta[k] = np.clip(theta[k] + move * free.scale, free.low, free.high)
    return replace(rival, model=model.with_theta(theta))
