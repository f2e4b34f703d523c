"""One candidate fitted on the fit logs and judged on the hold-out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from config.schema.effect_entry import EffectEntry
from config.schema.effect_library import EFFECTS
from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.fitting.compare import paired_t
from gap.fitting.convergence import fitted_to_its_end
from gap.fitting.evaluation import Costing, Evaluation, evaluate, judged, mean_cost
from gap.fitting.fit import Fit, covariance, fit
from gap.fitting.initial_states import Projection, marginalised
from gap.fitting.model import Model
from gap.fitting.sensitivity import projected
from gap.fitting.thinned import thinned
from gap.signatures.candidates import Candidate
from sim_backend.memory.layout import C

FLOOR = 1.0
LEAST_GAIN = 0.15  # of the remaining excess over the floor: less is within what constants and friction of another form can feign
NEARLY_ALL = 0.9  # gain after which no other start or sign is tried
STARTS = 2
STEPS = 5


@dataclass(frozen=True, slots=True)
class Base:
    """What a candidate is added to: the current model on the fit logs and on the hold-out."""

    experiments: Sequence[Experiment]
    holdouts: Sequence[Experiment]
    costs: Costing
    current: Fit
    seen: tuple[Evaluation, ...]

    @property
    def cost(self) -> float:
        return mean_cost(self.seen)

    @property
    def plain(self) -> Base:
        """The same with the friction's states and form known, for candidates that may change the friction beyond recognition."""
        now = tuple(_plain(e, self.costs) for e in self.current.evaluations)
        columns = tuple(projected(e, j) for e, j in zip(now, self.current.jacobian, strict=True))
        current = replace(self.current, evaluations=now, columns=columns)
        return replace(self, current=current, seen=tuple(_plain(e, self.costs) for e in self.seen))

    @property
    def rough(self) -> Base:
        """The same with half of the windows to fit: enough to see which candidates are worth a fit to all of them."""
        current, _ = thinned(self.current)
        return replace(self, experiments=[e.experiment for e in current.evaluations], current=current)


def _plain(now: Evaluation, costs: Costing) -> Evaluation:
    return judged(now.experiment, now.readings, now.projection.plain, costs)


@dataclass(frozen=True, slots=True)
class Trial:
    """One candidate fitted: what it gains on the hold-out."""

    candidate: Candidate
    fit: Fit  # with the sensitivities of the candidate's own parameters only
    holdout: tuple[Evaluation, ...]
    gain: float  # share of the excess over the floor that it takes away
    drop: float  # noise floors
    t: float
    has_size: bool  # the 95 % interval of one of its parameters excludes the neutral value
    beside: Candidate | None = None  # the sign of a sensor that was reversed with it
    own: bool = False  # judged about its own start states, which a name needs

    @property
    def cost(self) -> float:
        return mean_cost(self.holdout)

    @property
    def everywhere(self) -> tuple[Evaluation, ...]:
        """On the fit logs and on the hold-out."""
        return (*self.fit.evaluations, *self.holdout)

    def beside_cost(self, cost: float, t: float) -> Trial:
        """The same judged beside a model that leaves `cost` of the hold-out."""
        drop = cost - self.cost
        return replace(self, drop=drop, gain=drop / excess(cost), t=t)


def first_trial(base: Base, candidate: Candidate, starts: Sequence[Model]) -> Trial:
    """Fit from the best starting point, from the next as well if that brings little; initial states as those of the current model."""
    best: Fit | None = None
    for start in starts[:STARTS]:
        done = _fitted(base, start)
        best = done if best is None or done.cost < best.cost else best
        if excess(best.cost) < (1 - NEARLY_ALL) * excess(base.current.cost):
            break
    assert best is not None
    known = [e.projection for e in base.seen] if _same_states(base, best.model) else None
    return _judged(base, candidate, best, known)


def own_trial(base: Base, trial: Trial, others: Sequence[Fit]) -> Trial:
    """The same candidate with initial states marginalised about its own model, from its own constants and from those of `others`, once
    with these held: fits with old sensitivities of the constants end a little beside the best place, and that costs votes."""
    model = trial.fit.model
    own = [marginalised(e, model.vector()) for e in base.experiments]
    fits = [fit(model, base.experiments, base.costs, effects(model), _with_new(base.current, model), 3, own)]
    for other in others:
        moved = model.with_theta(np.concatenate([other.model.theta, model.theta[len(other.model.theta) :]]))
        fits.append(fit(moved, base.experiments, base.costs, effects(model), _with_new(other, model), STEPS, own))
        if effects(model):
            fits.append(_effects_fitted(base, moved, other, own))
    return replace(_judged(base, trial.candidate, min(fits, key=lambda done: done.cost), None), own=True)


def joint_trial(base: Base, candidate: Candidate, start: Model, nominal: Fit) -> Trial:
    """The candidate and all constants fitted together from `start`, sensitivities and start states renewed on the way."""
    done, _ = fitted_to_its_end(start, base.experiments, base.costs, nominal.evaluations)
    return replace(_judged(base, candidate, done, None), own=True)


def _effects_fitted(base: Base, moved: Model, other: Fit, own: Sequence[Projection]) -> Fit:
    """Only the effects fitted, the constants as they are in `other`, which has none of the effects."""
    reached, done = effects_only(moved, base.experiments, base.costs, own)
    columns = tuple(
        np.concatenate([projected(e, known), new]) for e, known, new in zip(done.evaluations, other.jacobian, done.columns, strict=True)
    )
    return Fit(reached, done.evaluations, tuple(_with_new(other, moved)), columns, done.objective)


def _with_new(known: Fit, model: Model) -> list[Array]:
    """Sensitivities of the constants as known, with room for those of the candidate."""
    return [_grown(columns, len(model.free)) for columns in known.jacobian]


def effects(model: Model) -> list[int]:
    """Numbers of the parameters of the effects found so far."""
    return [k for entry in model.added for k in model.of_effect(entry)]


def effects_only(model: Model, experiments: Sequence[Experiment], costs: Costing, projections: Sequence[Projection]) -> tuple[Model, Fit]:
    """The effects found so far fitted with every constant held: the whole model then, and the fit of the effects' parameters."""
    numbers = effects(model)
    done = fit(model.restricted(numbers), experiments, costs, range(len(numbers)), None, STEPS, projections)
    theta = model.theta.copy()
    theta[numbers] = done.model.theta
    return model.with_theta(theta), done


def excess(cost: float) -> float:
    """What a cost is above the noise."""
    return max(cost - FLOOR, 1e-9)


def _fitted(base: Base, model: Model) -> Fit:
    origin = base.current
    jacobian = _with_new(origin, model)
    known = [e.projection for e in origin.evaluations] if _same_states(base, model) else None
    new = model.of_effect(model.added[-1])
    return fit(model, base.experiments, base.costs, new, jacobian, STEPS, known)


def _same_states(base: Base, model: Model) -> bool:
    """Whether both models have the same initial states: a link that bends has more."""
    return bool((model.vector()[C.BENDING_STIFFNESS] > 0) == (base.current.model.vector()[C.BENDING_STIFFNESS] > 0))


def _judged(base: Base, candidate: Candidate, best: Fit, projections: Sequence[Projection] | None) -> Trial:
    after = tuple(evaluate(e, best.model, base.costs, projections[k] if projections else None) for k, e in enumerate(base.holdouts))
    sized = has_size(best, best.model.added[-1], base.costs)
    known = len(base.current.model.free)  # a trial keeps the candidate's sensitivities only: a dozen of them are alive together
    slim = replace(best, jacobian=tuple(j[known:].copy() for j in best.jacobian), columns=())
    trial = Trial(candidate, slim, after, 0.0, 0.0, 0.0, sized)
    return trial.beside_cost(base.cost, paired_t(base.seen, after)) if sized else trial


def has_size(done: Fit, entry: EffectEntry, costs: Costing) -> bool:
    """Whether the fit has moved the effect away from its neutral value by more than its uncertainty; else what it gained, the constants
    have gained."""
    return clear_of_neutral(done.model, entry, 1.96 * np.sqrt(np.maximum(np.diag(covariance(done, costs)), 0.0)))


def clear_of_neutral(model: Model, entry: EffectEntry, half_width: Array) -> bool:
    """Whether one of the effect's parameters is further from its neutral value than the half width of its interval, or none has one."""
    numbers, neutral = sized_by(model, entry), EFFECTS[entry.effect].neutral
    return not numbers or any(abs(model.theta[k] - neutral[model.free[k].key]) > half_width[k] for k in numbers)


def sized_by(model: Model, entry: EffectEntry) -> list[int]:
    """Numbers of the effect's parameters that have a neutral value."""
    return [k for k in model.of_effect(entry) if model.free[k].key in EFFECTS[entry.effect].neutral]


def _grown(columns: Array, count: int) -> Array:
    return np.concatenate([columns, np.zeros((count - len(columns), *columns.shape[1:]))])
