"""Forward, swap and backward selection. Fits use the fit logs only; every decision is made on the hold-out logs, window by window."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import norm

from config.effect_entry import EffectEntry
from gap.candidates import Candidate, candidates
from gap.fit import Costing, Evaluation, Fit, evaluate, fit, mean_cost
from gap.measured import Array
from gap.model import Model
from gap.screen import Screening, points, screen
from gap.windows import Experiment, Projection, marginalised
from sim_backend.effects.registry import REGISTRY
from sim_backend.layout import C

LEAST_T = 3.5
FALSE_ALARM = 0.014  # of a whole search, shared by all candidates and stages
LEAST_GAIN = 0.10  # of the remaining excess over the floor
LEAST_DROP = 0.02  # noise floors
KEEP_T = 2.0  # an accepted effect that is worth less than this leaves again
RIVAL_T = 3.0
RIVAL_GAIN = 0.8
MOST_EFFECTS = 4
STARTS = 2
REFIT_STEPS = 8
CONVERGED = 1e-3  # a base that has not converged would sell its rest to the next candidate
NOTHING = 0.01  # typical sizes: an effect this close to its neutral value is none
TRIAL_STEPS = 5
LEAST_CHANGE = 0.02  # relative change of a window's cost that counts as a change
LARGEST_CHANGE = 0.2  # beyond it a window only says "much better": no single window decides
LEAST_SPREAD = 0.05  # of a window's gain; more windows than that agree in no real log
LEAST_TELLING = 6  # windows that must change, for the others to be left out
NEARLY_ALL = 0.9  # gain after which candidates with hardly any signature of the gap need no fit
HARDLY = 0.15  # of the best signature's share
FLOOR = 1.0

Tell = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Trial:
    """One candidate fitted: what it gains on the hold-out."""

    candidate: Candidate
    fit: Fit
    holdout: tuple[Evaluation, ...]
    gain: float  # share of the excess over the floor that it takes away
    drop: float  # noise floors
    t: float

    @property
    def cost(self) -> float:
        return mean_cost(self.holdout)


@dataclass(frozen=True, slots=True)
class Step:
    """One accepted effect with its rivals: candidates the hold-out cannot tell from it."""

    entry: EffectEntry
    trial: Trial
    rivals: tuple[Trial, ...]
    others: tuple[Trial, ...]


@dataclass(slots=True)
class Search:
    """The course of a search, from the refitted nominal model to the final one."""

    experiments: Sequence[Experiment]
    holdouts: Sequence[Experiment]
    costs: Costing
    channels: frozenset[str]
    nominal: Fit  # the rig file's own constants
    current: Fit
    seen: tuple[Evaluation, ...]  # hold-out with the current model
    steps: list[Step] = field(default_factory=list)
    screening: Screening | None = None
    first_screening: Screening | None = None
    last_trials: tuple[Trial, ...] = ()

    @property
    def cost(self) -> float:
        return mean_cost(self.seen)


def search(state: Search, tell: Tell) -> Search:
    """Add effects while the hold-out says so."""
    while len(state.steps) < MOST_EFFECTS:
        found = candidates(state.current.model.rig, state.channels)
        state.screening = screen(state.current, state.costs, found, tell)
        state.first_screening = state.first_screening or state.screening
        if state.cost < FLOOR + LEAST_DROP:
            break  # no candidate could pass the gates any more
        state.last_trials = tuple(sorted(_trials(state, state.screening, tell), key=lambda trial: trial.cost))
        step = _decide(state, len(found))
        if step is None:
            break
        _accept(state, step, tell)
        _swap(state, tell)
        _drop_superfluous(state, tell)
    return state


def _trials(state: Search, screening: Screening, tell: Tell) -> list[Trial]:
    """Fit the candidates that passed the screening, best signature first."""
    shares = {s.candidate.label: s.share for s in screening.signatures}
    most = max(shares.values(), default=0.0)
    trials: list[Trial] = []
    for candidate in screening.kept():
        nearly_all = any(trial.gain >= NEARLY_ALL for trial in trials)
        if not (nearly_all and shares[candidate.label] < HARDLY * most):
            trials.append(_try(state, candidate, tell))
    return trials


def paired_t(before: Sequence[Evaluation], after: Sequence[Evaluation]) -> float:
    """t of the mean relative gain ln(before / after) per window; neighbouring windows may be correlated (Newey-West with one lag).

    The logarithm, and bounded, because a gap shows in few windows with costs a thousand times those of the others; whether the sum of
    the costs falls is the gain's business.
    Windows in which both models do the same (nothing moves there) say nothing about either and are left out.
    """
    ratios = [np.log(a.window_costs / b.window_costs) for a, b in zip(before, after, strict=True)]
    gains = [np.clip(r, -LARGEST_CHANGE, LARGEST_CHANGE) for r in ratios]
    told = np.concatenate(gains)
    kept = np.abs(told) > LEAST_CHANGE
    if kept.sum() >= LEAST_TELLING:
        gains = [g[np.abs(g) > LEAST_CHANGE] for g in gains]
    pooled = np.concatenate(gains)
    mean = float(pooled.mean())
    variance = float(np.mean((pooled - mean) ** 2))
    lagged = sum(float(np.sum((g[1:] - mean) * (g[:-1] - mean))) for g in gains) / len(pooled)
    spread = (max(variance + lagged, 0.25 * variance) + LEAST_SPREAD**2) / len(pooled)
    return mean / float(np.sqrt(spread))


def _try(state: Search, candidate: Candidate, tell: Tell) -> Trial:
    """Fit from the best two starting points and judge on the hold-out; what helps is fitted on about its own initial states."""
    models = [(state.current, m) for m in points(candidate, state.current.model)[: len(candidate.starts)]]
    if not state.steps:  # constants torn away by the missing effect are a bad place to start from
        models += [(state.nominal, m) for m in points(candidate, state.nominal.model)[: len(candidate.starts)]]
    ranked = sorted(((_start_cost(state, model), k) for k, (_, model) in enumerate(models)))
    best: Fit | None = None
    for _, k in ranked[:STARTS]:
        done = _fitted(state, *models[k], None)
        best = done if best is None or done.cost < best.cost else best
        if _excess(best.cost) < (1 - NEARLY_ALL) * _excess(state.current.cost):
            break
    assert best is not None
    trial = _judge(state, candidate, best, [e.projection for e in state.seen])
    if trial.gain >= LEAST_GAIN:
        own = [marginalised(e, best.model.vector()) for e in state.experiments]
        trial = _judge(state, candidate, _refined(state, best, own), None)
    tell(f"  {candidate.label}: hold-out {state.cost:.4g} → {trial.cost:.4g} noise floors, t = {trial.t:.1f}")
    return trial


def _fitted(state: Search, origin: Fit, model: Model, projections: Sequence[Projection] | None) -> Fit:
    jacobian = [_grown(columns, len(model.free)) for columns in origin.jacobian]
    same_states = (model.vector()[C.BENDING_STIFFNESS] > 0) == (origin.model.vector()[C.BENDING_STIFFNESS] > 0)
    if projections is None and same_states:
        projections = [e.projection for e in origin.evaluations]
    return fit(model, state.experiments, state.costs, _moving(model), jacobian, TRIAL_STEPS, projections)


def _refined(state: Search, done: Fit, projections: Sequence[Projection]) -> Fit:
    return fit(done.model, state.experiments, state.costs, _moving(done.model), done.jacobian, 3, projections)


def _moving(model: Model) -> list[int]:
    """The parameters of the effects found so far."""
    return [k for entry in model.added for k in model.of_effect(entry)]


def _excess(cost: float) -> float:
    return max(cost - FLOOR, 1e-9)


def _start_cost(state: Search, model: Model) -> float:
    pairs = zip(state.experiments, state.current.evaluations, strict=True)
    return mean_cost([evaluate(e, model, state.costs, old.projection) for e, old in pairs])


def _judge(state: Search, candidate: Candidate, best: Fit, projections: Sequence[Projection] | None) -> Trial:
    after = tuple(evaluate(e, best.model, state.costs, projections[k] if projections else None) for k, e in enumerate(state.holdouts))
    drop = state.cost - mean_cost(after)
    gain = drop / _excess(state.cost)
    if _vanished(candidate, best):
        return Trial(candidate, best, after, 0.0, 0.0, 0.0)
    return Trial(candidate, best, after, gain, drop, paired_t(state.seen, after))


def _vanished(candidate: Candidate, best: Fit) -> bool:
    """Whether the fit has put the effect back to its neutral value: what it gained, the constants have gained."""
    numbers = best.model.of_effect(best.model.added[-1])
    pairs = [(abs(best.model.theta[k] - free.start), free) for k, free in zip(numbers, candidate.free, strict=True)]
    resting = [moved < NOTHING * free.scale for moved, free in pairs if free.key in REGISTRY[candidate.effect].neutral]
    return bool(resting) and all(resting)


def _grown(columns: Array, count: int) -> Array:
    return np.concatenate([columns, np.zeros((count - len(columns), *columns.shape[1:]))])


def _decide(state: Search, tried: int) -> Step | None:
    """The best candidate that passes all gates, or None. Of equals, the one with the fewest parameters."""
    threshold = max(LEAST_T, float(norm.isf(FALSE_ALARM / (3 * max(tried, 1)))))
    passed = [t for t in state.last_trials if t.t > threshold and t.gain >= LEAST_GAIN and t.drop >= LEAST_DROP]
    if not passed:
        return None
    best = min(passed, key=lambda trial: trial.cost)
    rivals = [t for t in passed if t is not best and paired_t(t.holdout, best.holdout) < RIVAL_T and t.gain >= RIVAL_GAIN * best.gain]
    simplest = min([best, *rivals], key=lambda t: (len(t.candidate.free), t.cost))
    equals = tuple(t for t in [best, *rivals] if t is not simplest)
    others = tuple(t for t in state.last_trials if t is not simplest and t not in equals)
    return Step(simplest.fit.model.added[-1], simplest, equals, others)


def _accept(state: Search, step: Step, tell: Tell) -> None:
    state.steps.append(step)
    rivals = f" (or {', '.join(r.candidate.label for r in step.rivals)})" if step.rivals else ""
    tell(f"accepted: {step.trial.candidate.label}{rivals}")
    _refit(state, step.trial.fit, tell)


def _refit(state: Search, start: Fit, tell: Tell) -> None:
    """All numbers again, with all sensitivities new; from the rig file's own constants when these are the better place to start."""
    tell("refitting all constants")
    own = _from_own_constants(state, start)
    best = own if own.cost < start.cost else start
    state.current = fit(best.model, state.experiments, state.costs, range(len(best.model.free)), None, REFIT_STEPS, enough=CONVERGED)
    state.seen = tuple(evaluate(e, state.current.model, state.costs) for e in state.holdouts)


def _from_own_constants(state: Search, start: Fit) -> Fit:
    """Only the effects fitted, every constant as in the rig file: what the missing effect had torn away stands right again."""
    model = start.model
    theta = np.array([free.start if free.prior else value for free, value in zip(model.free, model.theta, strict=True)])
    plain = model.with_theta(theta)
    numbers = _moving(plain)
    smaller = plain.restricted(numbers)
    done = fit(smaller, state.experiments, state.costs, range(len(numbers)), None, TRIAL_STEPS)
    theta[numbers] = done.model.theta
    return Fit(plain.with_theta(theta), done.evaluations, start.jacobian, done.objective)


def _swap(state: Search, tell: Tell) -> None:
    """Replace each earlier effect by its best rival of that time, if that is now better."""
    for number, step in enumerate(state.steps[:-1]):
        present = {(e.effect, e.where) for e in state.current.model.added}
        rivals = [t for t in (*step.rivals, *step.others) if (t.candidate.effect, t.candidate.where) not in present]
        if not rivals:
            continue
        rival = min(rivals, key=lambda t: t.cost)
        without = _without(state, step.entry)
        if without is None:
            continue
        shrunk = Search(
            state.experiments, state.holdouts, state.costs, state.channels, state.nominal, without, _seen(state, without), [step]
        )
        trial = _try(shrunk, rival.candidate, tell)
        if paired_t(state.seen, trial.holdout) > KEEP_T:
            tell(f"swapped: {rival.candidate.label} in place of {step.trial.candidate.label}")
            state.steps[number] = Step(trial.fit.model.added[-1], trial, (step.trial,), ())
            _refit(state, trial.fit, tell)


def _drop_superfluous(state: Search, tell: Tell) -> None:
    """Take out each earlier effect that later ones have made worthless."""
    for step in list(state.steps[:-1]):
        without = _without(state, step.entry)
        if without is None:
            continue
        seen = _seen(state, without)
        if paired_t(seen, state.seen) < KEEP_T:
            tell(f"dropped: {step.trial.candidate.label} explains nothing that the others do not")
            state.steps.remove(step)
            _refit(state, without, tell)


def _without(state: Search, entry: EffectEntry) -> Fit | None:
    """The current model refitted without one of its effects."""
    model = state.current.model
    if not any(other is entry for other in model.added):
        return None
    gone = set(model.of_effect(entry))
    keep = [k for k in range(len(model.free)) if k not in gone]
    smaller = model.without_effect(entry)
    return fit(smaller, state.experiments, state.costs, _moving(smaller), [columns[keep] for columns in state.current.jacobian], steps=4)


def _seen(state: Search, done: Fit) -> tuple[Evaluation, ...]:
    return tuple(evaluate(e, done.model, state.costs) for e in state.holdouts)
