"""After the search: do the names hold in the finished model? A rival is exchanged in where it was not clearly worse at the time, and an
effect that the finished model does not need goes, and so does a rival that only did as well while a later effect was missing.

A name is chosen among first fits, each with constants of its own. What looks clearly better there may only have been the better fit: in
the finished model, with the same constants and the other effects, the rival may do as well. What could not be told apart there may be
once the later effects are known. And an effect accepted beside a poor fit of the constants can end with nothing to do.
"""

from __future__ import annotations

from dataclasses import replace

from config.progress import Progress
from gap.fitting.compare import separation_t
from gap.fitting.convergence import whole_fit
from gap.fitting.evaluation import evaluate, mean_cost
from gap.fitting.fit import unfitted
from gap.fitting.initial_states import marginalised
from gap.fitting.model import Model
from gap.search.search_state import LEAST_DROP, RIVAL_GAIN, RIVAL_T, GateSearch, Step
from gap.search.trial import Trial, effects, effects_only
from gap.search.verdict import CLOSED


def weighed_finally(state: GateSearch, progress: Progress) -> GateSearch:
    """The search with effects dropped that are not needed, and with rivals that do as well in the finished model. Only where the gap is
    closed: what a model leaves open decides between rivals by chance, and its names are tentative anyhow."""
    if state.cost > CLOSED:
        return state
    for step in reversed(state.steps):
        if len(state.steps) > 1:
            state = _dropped(state, step, progress)
    for number, step in enumerate(state.steps[:-1]):
        state = state.with_step(number, replace(step, rivals=tuple(t for t in step.rivals if _stands(state, step, t, progress))))
    for number, step in enumerate(state.steps):
        known = {trial.candidate.label for trial in step.rivals}
        near = [t for t in step.others if t.gain >= RIVAL_GAIN * step.trial.gain and t.candidate.label not in known]
        found = [trial for other in near if (trial := _exchanged(state, step, other)) is not None]
        for trial in found:
            progress(f"{trial.candidate.label} does as well as {step.trial.candidate.label} in the finished model")
        others = tuple(t for t in step.others if _new(t, found))
        state = state.with_step(number, replace(step, rivals=(*step.rivals, *found), others=others))
    return state


def _new(trial: Trial, found: list[Trial]) -> bool:
    return all(trial.candidate.label != other.candidate.label for other in found)


def _dropped(state: GateSearch, step: Step, progress: Progress) -> GateSearch:
    """The search without the effect when the others, fitted again with the rig file's own constants, leave no more than is worth one."""
    model = state.current.model.without_effect(step.entry).with_own_constants()
    if not effects(model):
        return state
    reached = _effects_fitted(state, model)
    seen = tuple(evaluate(e, reached, state.costs) for e in state.holdouts)
    if mean_cost(seen) - state.cost > LEAST_DROP:
        return state
    progress(f"dropped: {step.trial.candidate.label}; without it the hold-out is at {mean_cost(seen):.4g} noise floors")
    now = unfitted(reached, [evaluate(e, reached, state.costs) for e in state.experiments], state.costs)
    return replace(state.without_step(step), current=now, seen=seen)


def _stands(state: GateSearch, step: Step, rival: Trial, progress: Progress) -> bool:
    """Whether the hold-out still does not tell the rival from the step, both beside the effects that were found later. The rival has all
    constants for it too: those of the finished model were fitted beside the name that was chosen."""
    model = _in_place(state, step, rival)
    if model is None:
        return True
    done = whole_fit(model, state.experiments, state.costs).model
    seen = tuple(evaluate(e, done, state.costs) for e in state.holdouts)
    if separation_t(seen, state.seen) < RIVAL_T:
        return True
    label = f"{rival.candidate.label} in the place of {step.trial.candidate.label}"
    progress(f"no look-alike in the finished model: {label} leaves {mean_cost(seen):.4g} noise floors of the hold-out")
    return False


def _exchanged(state: GateSearch, step: Step, other: Trial) -> Trial | None:
    """The rival in the step's place, its size and those of the other effects fitted again; None when that is clearly worse."""
    model = _in_place(state, step, other)
    if model is None:
        return None
    seen = tuple(evaluate(e, model, state.costs) for e in state.holdouts)
    if separation_t(seen, state.seen) >= RIVAL_T:
        return None
    return replace(other, fit=replace(other.fit, model=model), holdout=seen)


def _in_place(state: GateSearch, step: Step, other: Trial) -> Model | None:
    """The finished model with the rival in the step's place, sizes fitted again; None where it stands there already or turned a sign."""
    present = {(entry.effect, entry.where) for entry in state.current.model.added}
    candidate, fitted = other.candidate, other.fit.model
    if (candidate.effect, candidate.where) in present or other.beside is not None:
        return None
    model = state.current.model.without_effect(step.entry).with_effect(candidate.entry, candidate.free)
    theta, numbers = model.theta.copy(), model.of_effect(model.added[-1])
    theta[numbers] = fitted.theta[fitted.of_effect(fitted.added[-1])]
    model = model.with_theta(theta)
    return _effects_fitted(state, model) if effects(model) else model


def _effects_fitted(state: GateSearch, model: Model) -> Model:
    own = [marginalised(e, model.vector()) for e in state.experiments]
    return effects_only(model, state.experiments, state.costs, own)[0]
