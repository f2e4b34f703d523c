"""After the search: do the names hold in the finished model? A rival is exchanged in where it was not clearly worse at the time, and an
effect that the finished model does not need goes.

A name is chosen among first fits, each with constants of its own. What looks clearly better there may only have been the better fit: in
the finished model, with the same constants and the other effects, the rival may do as well. And an effect accepted beside a poor fit of the
constants can end with nothing to do.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from gap.fitting.compare import separation_t
from gap.fitting.evaluation import evaluate, mean_cost
from gap.fitting.fit import unfitted
from gap.fitting.initial_states import marginalised
from gap.fitting.model import Model
from gap.search.search_state import LEAST_DROP, RIVAL_GAIN, RIVAL_T, Search, Step
from gap.search.trial import Trial, effects, effects_only
from gap.search.verdict import CLOSED

Tell = Callable[[str], None]


def last_look(state: Search, tell: Tell) -> Search:
    """The search with effects dropped that are not needed, and with rivals that do as well in the finished model. Only where the gap is
    closed: what a model leaves open decides between rivals by chance, and its names are tentative anyhow."""
    if state.cost > CLOSED:
        return state
    for step in reversed(list(state.steps)):
        if len(state.steps) > 1:
            _dropped(state, step, tell)
    for number, step in enumerate(state.steps):
        known = {trial.candidate.label for trial in step.rivals}
        near = [t for t in step.others if t.gain >= RIVAL_GAIN * step.trial.gain and t.candidate.label not in known]
        found = [trial for other in near if (trial := _exchanged(state, step, other)) is not None]
        for trial in found:
            tell(f"{trial.candidate.label} does as well as {step.trial.candidate.label} in the finished model")
        state.steps[number] = replace(step, rivals=(*step.rivals, *found), others=tuple(t for t in step.others if _new(t, found)))
    return state


def _new(trial: Trial, found: list[Trial]) -> bool:
    return all(trial.candidate.label != other.candidate.label for other in found)


def _dropped(state: Search, step: Step, tell: Tell) -> None:
    """Take the effect out when the others, fitted again with the rig file's own constants, leave no more than is worth an effect."""
    model = state.current.model.without_effect(step.entry).with_own_constants()
    if not effects(model):
        return
    reached = _effects_fitted(state, model)
    seen = tuple(evaluate(e, reached, state.costs) for e in state.holdouts)
    if mean_cost(seen) - state.cost > LEAST_DROP:
        return
    tell(f"dropped: {step.trial.candidate.label}; without it the hold-out is at {mean_cost(seen):.4g} noise floors")
    state.steps.remove(step)
    state.current = unfitted(reached, [evaluate(e, reached, state.costs) for e in state.experiments], state.costs)
    state.seen = seen


def _exchanged(state: Search, step: Step, other: Trial) -> Trial | None:
    """The rival in the step's place, its size and those of the other effects fitted again; None when that is clearly worse."""
    present = {(entry.effect, entry.where) for entry in state.current.model.added}
    candidate, fitted = other.candidate, other.fit.model
    if (candidate.effect, candidate.where) in present or other.beside is not None:
        return None
    model = state.current.model.without_effect(step.entry).with_effect(candidate.entry, candidate.free)
    theta, numbers = model.theta.copy(), model.of_effect(model.added[-1])
    theta[numbers] = fitted.theta[fitted.of_effect(fitted.added[-1])]
    model = model.with_theta(theta)
    reached = _effects_fitted(state, model) if effects(model) else model
    seen = tuple(evaluate(e, reached, state.costs) for e in state.holdouts)
    if separation_t(seen, state.seen) >= RIVAL_T:
        return None
    return replace(other, fit=replace(other.fit, model=reached), holdout=seen)


def _effects_fitted(state: Search, model: Model) -> Model:
    own = [marginalised(e, model.vector()) for e in state.experiments]
    return effects_only(model, state.experiments, state.costs, own)[0]
