"""Forward, swap and backward selection. Fits use the fit logs only; every decision is made on the hold-out logs, window by window."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.stats import norm

from config.effect_entry import EffectEntry
from gap.candidates import candidates
from gap.compare import paired_t, separation_t
from gap.evaluation import Costing, Evaluation, evaluate, mean_cost
from gap.fit import CONVERGED, Fit, fit, settled
from gap.screen import VISIBLE, Screening, Signature, points, screen
from gap.simulate import remembering
from gap.trial import FLOOR, LEAST_GAIN, NEARLY_ALL, STEPS, Base, Trial, effects, first_trial, own_trial
from gap.turned import turned_trials
from gap.windows import Experiment

LEAST_T = 3.5
FALSE_ALARM = 0.014  # of a whole search, shared by all candidates and stages
LEAST_DROP = 0.02  # noise floors
KEEP_T = 2.0  # an accepted effect that is worth less than this leaves again
RIVAL_T = 3.0
RIVAL_GAIN = 0.8
CONTENDER = 0.7  # of the best first trial's gain, from which a candidate is fitted about its own initial states
MOST_EFFECTS = 4
REFIT_STEPS = 8
HARDLY = 0.15  # of the best signature's share
FIRST_WAVE = 4

Tell = Callable[[str], None]


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
    workers: int = 1
    steps: list[Step] = field(default_factory=list)
    screening: Screening | None = None
    first_screening: Screening | None = None
    last_trials: tuple[Trial, ...] = ()

    @property
    def cost(self) -> float:
        return mean_cost(self.seen)

    @property
    def least_drop(self) -> float:
        """The smallest fall of the hold-out's cost with which a candidate passes all gates. That of t: a fall that is even over the
        hold-out is known no better than the mean of its N values, √(2/N)."""
        values = sum(int(np.isfinite(e.measured).sum()) for e in self.holdouts)
        return max(LEAST_DROP, LEAST_GAIN * (self.cost - FLOOR), LEAST_T * float(np.sqrt(2.0 / values)))

    @property
    def seen_at(self) -> float:
        """Energy of a signature on the fit logs at which its effect would be named."""
        values = sum(int(np.isfinite(e.measured).sum()) for e in self.experiments)
        return max(VISIBLE**2 * self.costs.tau, self.least_drop * values)

    @property
    def base(self) -> Base:
        return Base(self.experiments, self.holdouts, self.costs, self.current, self.seen)


def search(state: Search, tell: Tell) -> Search:
    """Add effects while the hold-out says so."""
    while len(state.steps) < MOST_EFFECTS:
        state.screening = None
        if state.cost < FLOOR + LEAST_DROP:
            break  # no candidate could pass the gates any more
        found = candidates(state.current.model.rig, state.channels)
        state.screening = screen(state.current, state.costs, found, state.seen_at, tell)
        state.first_screening = state.first_screening or state.screening
        state.last_trials = tuple(sorted(_trials(state, state.screening, tell), key=lambda trial: trial.cost))
        step = _decide(state, len(found))
        if step is None:
            break
        _accept(state, step, tell)
        _swap(state, tell)
        _drop_superfluous(state, tell)
    return state


def _trials(state: Search, screening: Screening, tell: Tell) -> list[Trial]:
    """Fit the candidates that passed the screening, best signatures first; those that help most once more about their own states."""
    kept, base = screening.kept(), state.base
    most = max((s.share for s in kept), default=0.0)

    def first(signature: Signature) -> Trial:
        trial = first_trial(base, signature.candidate, signature.starts)
        tell(f"  {trial.candidate.label}: hold-out {state.cost:.4g} → {trial.cost:.4g} noise floors, t = {trial.t:.1f}")
        return trial

    others = [] if state.steps else [state.nominal]  # constants torn away by the missing effect are a bad place to start from

    def again(trial: Trial) -> Trial:
        own = own_trial(base, trial, others)
        tell(f"  {own.candidate.label}, own initial states: hold-out {own.cost:.4g} noise floors, t = {own.t:.1f}")
        return own

    with ThreadPoolExecutor(state.workers) as pool:
        trials = list(pool.map(first, kept[:FIRST_WAVE]))
        solved = any(trial.gain >= NEARLY_ALL for trial in trials)
        trials += pool.map(first, [s for s in kept[FIRST_WAVE:] if not (solved and s.share < HARDLY * most)])
        best = max((trial.gain for trial in trials), default=0.0)
        strong = [trial for trial in trials if trial.gain >= max(0.5 * LEAST_GAIN, CONTENDER * best)]
        weak = [trial for trial in trials if all(trial is not other for other in strong)]
        trials = [*weak, *pool.map(again, strong)]
    if any(trial.gain >= NEARLY_ALL for trial in trials):
        return trials
    for trial in turned_trials(base, [s.candidate for s in kept], state.channels, others):
        tell(f"  {trial.candidate.label}, sign of {trial.beside.where if trial.beside else ''} turned: {trial.cost:.4g} noise floors")
        trials.append(trial)
    return trials


def _decide(state: Search, tried: int) -> Step | None:
    """The best candidate that passes all gates, or None. Of equals, the one with the fewest parameters unless more are worth an effect."""
    threshold = max(LEAST_T, float(norm.isf(FALSE_ALARM / (3 * max(tried, 1)))))
    passed = [t for t in state.last_trials if t.t > threshold and t.gain >= LEAST_GAIN and t.drop >= LEAST_DROP and t.has_size]
    if not passed:
        return None
    best = min(passed, key=lambda trial: trial.cost)
    near = [t for t in passed if t is not best and t.gain >= RIVAL_GAIN * best.gain]
    rivals = [t for t in near if separation_t(t.holdout, best.holdout) < RIVAL_T]
    plain = [t for t in rivals if t.cost - best.cost < max(LEAST_DROP, LEAST_GAIN * (t.cost - FLOOR))]
    simplest = min([best, *plain], key=lambda t: (len(t.candidate.free), t.cost))
    equals = tuple(t for t in [best, *rivals] if t is not simplest)
    others = tuple(t for t in state.last_trials if t is not simplest and t not in equals)
    return Step(simplest.fit.model.added[-1], simplest, equals, others)


def _accept(state: Search, step: Step, tell: Tell) -> None:
    if step.trial.beside:
        state.steps.append(Step(step.trial.fit.model.added[-2], replace(step.trial, candidate=step.trial.beside, beside=None), (), ()))
    state.steps.append(step)
    rivals = f" (or {', '.join(r.candidate.label for r in step.rivals)})" if step.rivals else ""
    tell(f"accepted: {step.trial.candidate.label}{rivals}")
    _refit(state, step.trial.fit, tell)


def _refit(state: Search, start: Fit, tell: Tell) -> None:
    """All numbers again, with all sensitivities new; from the rig file's own constants when these are the better place to start."""
    tell("refitting all constants")
    own = _from_own_constants(state, start)
    best = own if own.cost < start.cost else start
    vector = best.model.vector()
    state.experiments = [remembering(e, vector) for e in state.experiments]
    done = fit(best.model, state.experiments, state.costs, range(len(best.model.free)), None, REFIT_STEPS, enough=CONVERGED)
    state.current, state.costs = settled(done, state.experiments, state.costs, REFIT_STEPS)
    state.seen = tuple(evaluate(e, state.current.model, state.costs) for e in state.holdouts)
    tell(f"hold-out: {state.cost:.4g} noise floors")


def _from_own_constants(state: Search, start: Fit) -> Fit:
    """Only the effects fitted, every constant as in the rig file: what the missing effect had torn away stands right again."""
    model = start.model
    theta = np.array([free.start if free.prior else value for free, value in zip(model.free, model.theta, strict=True)])
    plain = model.with_theta(theta)
    numbers = effects(plain)
    if not numbers:  # the sign of a sensor has nothing to fit
        now = tuple(evaluate(e, plain, state.costs) for e in state.experiments)
        return Fit(plain, now, start.jacobian, start.columns, start.objective)
    smaller = plain.restricted(numbers)
    known = [e.projection for e in start.evaluations]
    done = fit(smaller, state.experiments, state.costs, range(len(numbers)), None, STEPS, known)
    theta[numbers] = done.model.theta
    return Fit(plain.with_theta(theta), done.evaluations, start.jacobian, start.columns, done.objective)


def _swap(state: Search, tell: Tell) -> None:
    """Replace each earlier effect by its best rival of that time, if that is now better."""
    for number, step in enumerate(state.steps[:-1]):
        present = {(e.effect, e.where) for e in state.current.model.added}
        rivals = [t for t in (*step.rivals, *step.others) if (t.candidate.effect, t.candidate.where) not in present]
        without = _without(state, step.entry) if rivals else None
        if without is None:
            continue
        rival = min(rivals, key=lambda t: t.cost)
        base = Base(state.experiments, state.holdouts, state.costs, without, _seen(state, without))
        trial = own_trial(base, first_trial(base, rival.candidate, points(rival.candidate, without.model)), [])
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
    return fit(smaller, state.experiments, state.costs, effects(smaller), [columns[keep] for columns in state.current.jacobian], steps=4)


def _seen(state: Search, done: Fit) -> tuple[Evaluation, ...]:
    return tuple(evaluate(e, done.model, state.costs) for e in state.holdouts)
