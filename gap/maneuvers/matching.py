"""Two explanations that come from no fit, made as alike as they can be: before that, their distance says little."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from config.errors import LongreachError
from config.loading.load import LoadedRig
from gap.maneuvers.closed_loop import measured_on
from gap.maneuvers.designs import ManeuverDesign
from gap.maneuvers.separation import Comparison, Rival, RivalRun, observed
from gap.settings import PROCESSORS

_STEPS = 4
_ENOUGH = 0.99  # ratio of T from which a further step is not worth it


def matched(loaded: LoadedRig, first: Rival, second: Rival, maneuvers: Sequence[ManeuverDesign]) -> Rival:
    """The second with its own parameters fitted to the first, on the first of the maneuvers that can be run; as it is if none can."""
    run = next((run for design in maneuvers if (run := _run(loaded, first, design)) is not None), None)
    if run is None:
        return second
    best, least = second, np.inf
    for _ in range(_STEPS):
        comparison = run.beside(second)
        left = comparison.bound().T
        if _ENOUGH * least < left:
            break
        best, least = second, left
        second = _moved(second, comparison)
    return best


def _run(loaded: LoadedRig, truth: Rival, design: ManeuverDesign) -> RivalRun | None:
    try:
        return observed(loaded, truth, measured_on(truth.model.fitted_rig(), design.content), workers=PROCESSORS)
    except LongreachError:
        return None


def _moved(rival: Rival, comparison: Comparison) -> Rival:
    """One Gauss-Newton step of the second rival's own parameters, inside their ranges."""
    model = rival.model
    numbers = [k for k, free in enumerate(model.free) if not free.prior]
    theta = model.theta.copy()
    for k, move in zip(numbers, comparison.step(), strict=True):
        free = model.free[k]
        theta[k] = np.clip(theta[k] + move * free.scale, free.low, free.high)
    return replace(rival, model=model.with_theta(theta))
