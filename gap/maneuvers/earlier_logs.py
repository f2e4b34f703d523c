"""What the logs at hand say of an explanation's numbers: they are fitted beside the next one, and hold what it would move.

Without them a rival may move every constant within its prior, as if nothing had been measured yet, and few maneuvers seem to tell.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gap.data.measured import Array
from gap.fitting.evaluation import Costing, Evaluation, evaluate
from gap.fitting.fit import Fit
from gap.fitting.model import Model, Path
from gap.fitting.sensitivity import projected, sensitivities


@dataclass(frozen=True, slots=True)
class EarlierLogs:
    """Their cost rises by φᵀ H φ where the numbers leave their fitted values by φ scales; H: `information`, in the order of `paths`."""

    paths: tuple[Path, ...]
    fitted: Array
    information: Array

    def of(self, model: Model) -> tuple[Array, Array]:
        """H in the order of the model's free numbers (0 for those never fitted), and by how many scales these are off."""
        there: Mapping[Path, int] = {path: k for k, path in enumerate(self.paths)}
        pairs = [(k, there[free.path]) for k, free in enumerate(model.free) if free.path in there]
        information, off = np.zeros((len(model.free), len(model.free))), np.zeros(len(model.free))
        if pairs:
            mine, theirs = (list(side) for side in zip(*pairs, strict=True))
            information[np.ix_(mine, mine)] = self.information[np.ix_(theirs, theirs)]
            off[mine] = (model.theta[mine] - self.fitted[theirs]) / model.scales[mine]
        return information, off


def earlier_logs(model: Model, current: Fit, costs: Costing) -> EarlierLogs:
    """Of a model whose constants are felt as those of `current` are (known there), and whose other numbers are few (computed here)."""
    weight = 1.0 / (max(1.0, current.cost) * costs.tau)
    logs = zip(current.evaluations, current.columns, strict=True)
    information = sum((_information(model, current.model, seen, columns) for seen, columns in logs), np.zeros(2 * (len(model.free),)))
    return EarlierLogs(tuple(free.path for free in model.free), model.theta, weight * information)


def _information(model: Model, fitted: Model, seen: Evaluation, columns: Array) -> Array:
    """Of one log, in noise units. A link that bends has more start states than a rigid one: of the other's numbers nothing is known."""
    now = evaluate(seen.experiment, model, None)
    there = {free.path: k for k, free in enumerate(fitted.free) if free.prior and now.left.shape == seen.left.shape}
    constants = [k for k, free in enumerate(model.free) if free.path in there]
    new = [k for k, free in enumerate(model.free) if free.path not in there]
    known = [there[model.free[k].path] for k in constants]
    flat, own = columns.reshape(len(columns), -1), _sensitivities(model, now, new).reshape(len(new), now.left.size)
    found = np.zeros(2 * (len(model.free),))
    found[np.ix_(constants, constants)] = (flat @ flat.T)[np.ix_(known, known)]
    found[np.ix_(new, new)] = own @ own.T
    if constants and new:
        found[np.ix_(constants, new)] = (flat @ own.T)[known]
        found[np.ix_(new, constants)] = found[np.ix_(constants, new)].T
    return found


def _sensitivities(model: Model, now: Evaluation, numbers: Sequence[int]) -> Array:
    if not numbers:
        return np.zeros((0, *now.left.shape))
    return projected(now, sensitivities(model, [now.experiment], numbers, [now.readings])[0])
