"""What a fitted set says of itself with suspects less: by its own lines, without a fit.

    Z(S less s) = Z(S) p(s = 0 | y, S) / p(s = 0 | S)          (Dickey, Ann. Math. Stat. 42, 1971: Savage's density ratio)

Where joints stick, ln p is rough: sets that are fitted each for itself end on floors that differ by more than a suspect is worth, and the
one that was tried more often seems to be right. A size that its own set knows to two standard deviations only cannot be worth more than
that says.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from config.schema.effect_library import EFFECTS
from gap.evidence.lines import StraightFit, followed
from gap.evidence.score.changed import Changed
from gap.evidence.score.coordinates import of_other_priors, phi_of
from gap.evidence.score.hypothesis import Hypothesis, Seen, Suspect
from gap.fitting.model import Model


def nested(seen: Seen, fitted: Hypothesis, stated: Model) -> list[Hypothesis]:
    """A fitted set without one, some or all of its suspects that have a size. `stated`: the rig file's own numbers. (A link bends the more
    the less stiff it is: no line leads from there to a rigid one.)"""
    sized = [s for s in fitted.suspects if s.free and (isinstance(s, Changed) or s.smaller_is_weaker)]
    if not sized:
        return []
    whole = followed(seen, fitted)
    return [_less(seen, fitted, whole, gone, stated) for number in range(1, len(sized) + 1) for gone in combinations(sized, number)]


def _less(seen: Seen, fitted: Hypothesis, whole: StraightFit, gone: Sequence[Suspect], stated: Model) -> Hypothesis:
    """The set without some of them. `whole`: what its own lines tell with them, of which only the difference counts."""
    begun = _begun(seen, fitted, gone, stated)
    part = followed(seen, begun)
    return replace(begun, log_z=fitted.log_z + part.log_z - whole.log_z, windows=fitted.windows + part.windows - whole.windows)


def _begun(seen: Seen, fitted: Hypothesis, gone: Sequence[Suspect], stated: Model) -> Hypothesis:
    """The set where lines lead when the sizes of those suspects are taken back, all else as it stands."""
    model, at = fitted.model, fitted.at
    there, kept = _taken_back(model, gone, stated), _without_sizes(model, gone)
    step = phi_of(model.with_theta(there.theta)) - phi_of(model)
    readings = tuple(r + np.tensordot(step, j, 1) * e.sigma for r, j, e in zip(at.readings, at.jacobian, seen.experiments, strict=True))
    columns = tuple(of_other_priors(j, model, there)[kept] for j in at.jacobian)
    idle = np.isin(kept, _of_effects(model, gone))
    for column in columns:
        column[idle] = 0.0
    point = replace(at, model=there.restricted(kept), readings=readings, jacobian=columns)
    return replace(fitted, suspects=tuple(s for s in fitted.suspects if s not in gone), at=point)


def _taken_back(model: Model, gone: Sequence[Suspect], stated: Model) -> Model:
    """Sizes of missing effects at none; numbers that had changed with their own prior again, within what that allows."""
    for suspect in gone:
        model = suspect.with_own_prior(model, stated) if isinstance(suspect, Changed) else model
    theta, none = model.theta.copy(), _sizes(model, gone)
    theta[none] = [model.free[k].start for k in none]
    return model.with_theta(theta)


def _without_sizes(model: Model, gone: Sequence[Suspect]) -> list[int]:
    """Numbers that stay free: what else an effect has does nothing without a size, and is as little known as before."""
    return sorted(set(range(len(model.free))) - set(_sizes(model, gone)))


def _of_effects(model: Model, gone: Sequence[Suspect]) -> list[int]:
    """All numbers of missing effects among the suspects."""
    return [k for s in gone if not isinstance(s, Changed) for k in model.of_effect(model.entry_added(s.effect, s.where))]


def _sizes(model: Model, gone: Sequence[Suspect]) -> list[int]:
    added = [model.entry_added(s.effect, s.where) for s in gone if not isinstance(s, Changed)]
    return [k for entry in added for k in model.of_effect(entry) if model.free[k].key in EFFECTS[entry.effect].neutral]
