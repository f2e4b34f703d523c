"""Taking an accepted effect into the model, and earlier effects out of it again that later ones have made worthless or wrong."""

from __future__ import annotations

from dataclasses import replace

from config.progress import Progress
from config.schema.effect_entry import EffectEntry
from gap.fitting.compare import paired_t
from gap.fitting.convergence import REFIT_STEPS, settled, whole_fit
from gap.fitting.evaluation import Evaluation, evaluate, mean_cost
from gap.fitting.fit import Fit, fit
from gap.fitting.initial_states import marginalised
from gap.fitting.simulate import remembering
from gap.search.search_state import LEAST_DROP, GateSearch, Rest, Step
from gap.search.trial import Base, effects, effects_only, first_trial, has_size, own_trial
from gap.search.verdict import CLOSED
from gap.signatures.screen import points

KEEP_T = 2.0  # an accepted effect that is worth less than this leaves again
ROUNDS = 3  # of fitting the effects alone, each about start states of its own


def accept(state: GateSearch, step: Step, progress: Progress) -> GateSearch | None:
    """The search with the step's effect in its model, or with the first of its equals that keeps a size once all constants are free.

    None if none of them does: what such an effect gained by itself, the constants gain without it, and its name would be wrong.
    """
    equals = [step.trial, *step.rivals]
    for number, trial in enumerate(equals):
        rivals = tuple(equals[number + 1 :])
        taken = _taken(state, replace(step, entry=trial.fit.model.added[-1], trial=trial, rivals=rivals), progress)
        if has_size(taken.current, trial.fit.model.added[-1], state.costs):
            return taken
        progress(f"  {trial.candidate.label}: its interval holds the neutral value once all constants are free; not named")
    return None


def _taken(state: GateSearch, step: Step, progress: Progress) -> GateSearch:
    polarity = step.trial.beside
    beside = [Step(step.trial.fit.model.added[-2], replace(step.trial, candidate=polarity, beside=None), (), ())] if polarity else []
    rivals = f" (or {', '.join(r.candidate.label for r in step.rivals)})" if step.rivals else ""
    progress(f"accepted: {step.trial.candidate.label}{rivals}")
    return refit(replace(state, steps=(*state.steps, *beside, step)), step.trial.fit, progress)


def refit(state: GateSearch, start: Fit, progress: Progress) -> GateSearch:
    """The search with all numbers fitted again and all sensitivities new; from the rig file's own constants when these are the better place
    to start."""
    progress("refitting all constants")
    own = _from_own_constants(state, start)
    best = own if own.cost < start.cost else start
    vector = best.model.vector()
    experiments = [remembering(e, vector) for e in state.experiments]
    done, costs = settled(whole_fit(best.model, experiments, state.costs), experiments, state.costs, REFIT_STEPS)
    fitted = replace(state, experiments=experiments, costs=costs, current=done)
    fitted = replace(fitted, seen=on_holdouts(fitted, done))
    progress(f"hold-out: {fitted.cost:.4g} noise floors")
    return fitted


def _from_own_constants(state: GateSearch, start: Fit) -> Fit:
    """Only the effects fitted, every constant as in the rig file: what the missing effect had torn away stands right again."""
    plain = start.model.with_own_constants()
    if not effects(plain):  # the sign of a sensor has nothing to fit
        now = tuple(evaluate(e, plain, state.costs) for e in state.experiments)
        return Fit(plain, now, start.jacobian, start.columns, start.objective)
    reached, done = effects_only(plain, state.experiments, state.costs, [e.projection for e in start.evaluations])
    for _ in range(ROUNDS):  # an effect that was found beside wrong constants may be far from its place
        if done.cost <= CLOSED:
            break
        own = [marginalised(e, reached.vector()) for e in state.experiments]
        further, better = effects_only(reached, state.experiments, state.costs, own)
        if better.cost >= done.cost:
            break
        reached, done = further, better
    return Fit(reached, done.evaluations, start.jacobian, start.columns, done.objective)


def swap(state: GateSearch, progress: Progress) -> GateSearch:
    """The search with the best rival of that time in the place of each earlier effect, where that is now better."""
    for number, step in enumerate(state.steps[:-1]):
        present = {(e.effect, e.where) for e in state.current.model.added}
        rivals = [t for t in (*step.rivals, *step.others) if (t.candidate.effect, t.candidate.where) not in present]
        if not rivals:
            continue
        state, rest = without(state, step.entry)
        if rest is None:
            continue
        rival = min(rivals, key=lambda t: t.cost)
        base = Base(state.experiments, state.holdouts, state.costs, rest.fit, rest.seen)
        trial = own_trial(base, first_trial(base, rival.candidate, points(rival.candidate, rest.fit.model)), [])
        if paired_t(state.seen, trial.holdout) > KEEP_T:
            progress(f"swapped: {rival.candidate.label} in place of {step.trial.candidate.label}")
            state = refit(state.with_step(number, Step(trial.fit.model.added[-1], trial, (step.trial,), ())), trial.fit, progress)
    return state


def drop_superfluous(state: GateSearch, progress: Progress) -> GateSearch:
    """The search without the effects that are worth nothing any more: an earlier one beside later ones, and the newest where the constants,
    fitted on from where it has brought them, do without it."""
    for step in state.steps:
        state, rest = without(state, step.entry)
        if rest is not None and _needless(state, step, rest):
            state = dismiss(state, step, rest.fit, "explains nothing that the others and the constants do not", progress)
    return state


def _needless(state: GateSearch, step: Step, rest: Rest) -> bool:
    """The newest has just passed the gates of a first fit: it leaves only where the hold-out is no worse without it."""
    if step is state.steps[-1]:
        return mean_cost(rest.seen) - state.cost < LEAST_DROP
    return paired_t(rest.seen, state.seen) < KEEP_T


def dismiss(state: GateSearch, step: Step, start: Fit, why: str, progress: Progress) -> GateSearch:
    """The search without one of its names, fitted on from `start`."""
    progress(f"dropped: {step.trial.candidate.label} {why}")
    state = refit(state.without_step(step), start, progress)
    return state if state.steps else replace(state, constants_only=state.seen)


def without(state: GateSearch, entry: EffectEntry) -> tuple[GateSearch, Rest | None]:
    """The current model refitted without one of its effects, None when that is not in it; and the search that knows it: asked again of the
    same model (by the exchange, the drop and the last weighing of a name) it is not fitted again."""
    model = state.current.model
    if not any(other is entry for other in model.added):
        return state, None
    of_this = tuple(rest for rest in state.rests if rest.of is state.current)
    known = next((rest for rest in of_this if rest.entry is entry), None)
    if known is not None:
        return state, known
    gone = set(model.of_effect(entry))
    keep = [k for k in range(len(model.free)) if k not in gone]
    smaller, jacobian = model.without_effect(entry), [columns[keep] for columns in state.current.jacobian]
    done = fit(smaller, state.experiments, state.costs, effects(smaller), jacobian, steps=4)
    new = Rest(state.current, entry, done, on_holdouts(state, done))
    return replace(state, rests=(*of_this, new)), new


def on_holdouts(state: GateSearch, done: Fit) -> tuple[Evaluation, ...]:
    """The hold-out logs with a fitted model."""
    return tuple(evaluate(e, done.model, state.costs) for e in state.holdouts)
