"""An effect that only does what one of the rig file's constants does, and no more than that may be wrong by, is that constant.

An extra payload is a payload of another value. While a model is incomplete its constants stand where they do the missing effect's work, and
such an effect can be accepted to undo it; when the other effect is found, the two only add up to a constant within its prior.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from config.progress import Progress
from config.schema.effect_entry import EffectEntry
from config.schema.effect_library import EFFECTS
from gap.data.measured import Array
from gap.fitting.fit import Fit
from gap.fitting.nuisance import HONEST
from gap.search.acceptance import dismiss
from gap.search.search_state import GateSearch
from gap.search.trial import sized_by

ALIKE = 0.999  # cosine of two signatures that are one


def absorb(state: GateSearch, progress: Progress) -> GateSearch:
    """The search with a constant in the place of every effect that is one."""
    for step in state.steps:
        found = constant_instead(state.current, step.entry)
        if found is None:
            continue
        start, key, pull = found
        state = dismiss(state, step, start, f"is {key} within {pull:+.1f} prior standard deviations", progress)
    return state


def constant_instead(done: Fit, entry: EffectEntry) -> tuple[Fit, str, float] | None:
    """The model with a constant moved instead of the effect, which predicts the same; the constant's key, and how far it then is from its
    start in prior standard deviations. None where no constant does just what the effect does, or not within its honest prior."""
    model, numbers = done.model, done.model.of_effect(entry)
    if len(numbers) != 1 or sized_by(model, entry) != numbers:
        return None
    (number,) = numbers
    same = _same_signature(done, number)
    if same is None:
        return None
    alike, ratio = same
    free, own = model.free[alike], model.free[number]
    size = (model.theta[number] - EFFECTS[entry.effect].neutral[own.key]) / own.scale
    pull = float(model.pulls[alike] + ratio * size)
    value = free.start + pull * free.scale
    if abs(pull) > HONEST or not free.low <= value <= free.high:
        return None
    theta, keep = model.theta.copy(), [k for k in range(len(model.free)) if k != number]
    theta[alike] = value
    smaller = model.with_theta(theta).without_effect(entry)
    jacobian, columns = (tuple(c[keep] for c in parts) for parts in (done.jacobian, done.columns))
    return replace(done, model=smaller, jacobian=jacobian, columns=columns), free.key, pull


def _same_signature(done: Fit, number: int) -> tuple[int, float] | None:
    """The constant with the signature of this number, if there is one, and how many of the constant's scales one scale of the number is."""
    along, lengths = np.sum([_products(columns, number) for columns in done.columns], axis=0)
    prior = np.array([free.prior for free in done.model.free])
    cosines = np.where(prior, along / np.sqrt(np.maximum(lengths[number] * lengths, 1e-300)), 0.0)
    best = int(np.argmax(np.abs(cosines)))
    if abs(cosines[best]) < ALIKE:
        return None
    return best, float(along[best] / lengths[best])


def _products(columns: Array, number: int) -> Array:
    """Of every column: its product with that of `number`, and with itself."""
    flat = columns.reshape(len(columns), -1)
    return np.stack([flat @ flat[number], np.einsum("kn,kn->k", flat, flat)])
