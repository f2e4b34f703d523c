"""Forward, swap and backward selection. Fits use the fit logs only; every decision is made on the hold-out logs, window by window."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace

from scipy.stats import norm

from config.progress import Progress
from gap.fitting.compare import separation_t
from gap.search.absorbed import absorb
from gap.search.acceptance import accept, drop_superfluous, swap
from gap.search.reversed_sign import reversed_trials
from gap.search.search_state import LEAST_DROP, LEAST_T, RIVAL_GAIN, RIVAL_T, GateSearch, Step, worth
from gap.search.trial import FLOOR, LEAST_GAIN, NEARLY_ALL, Base, Trial, first_trial, own_trial
from gap.signatures.candidates import candidates
from gap.signatures.screen import Screening, Signature, screen

FALSE_ALARM = 0.014  # of a whole search, shared by all candidates and stages
CLOSING_T = 2.0  # enough for a candidate that takes nearly all of the gap
HALF, HALF_T = 0.5, 2.5  # enough for one that takes half of a gap …
PLAIN_DROP = 0.2  # … of at least so many noise floors, which constants fitted to their end do not leave by chance …
LEFT = 1.0  # … and leaves no more above the floor than friction of another form may; what leaves more is no explanation
CONTENDER = 0.7  # of the best first trial's gain, from which a candidate is fitted about its own initial states
MOST_EFFECTS = 4
MOST = 0.8  # gain of a first trial after which candidates with hardly any signature of the gap need no fit
HARDLY = 0.15  # of the best signature's share
FIRST_WAVE = 4
LEADING = 2  # best signatures that are fitted about their own states where none solves the gap: first trials hold friction's form known


def search(state: GateSearch, progress: Progress) -> GateSearch:
    """Add effects while the hold-out says so."""
    while len(state.steps) < MOST_EFFECTS:
        if state.cost < FLOOR + LEAST_DROP:
            break  # no candidate could pass the gates any more
        found = candidates(state.current.model.rig, state.channels)
        plain = state.base.plain
        screening = screen(plain.current, state.costs, found, state.seen_at, progress)
        trials = tuple(sorted(_trials(state, plain, screening, progress), key=lambda trial: trial.cost))
        state = replace(state, first_screening=state.first_screening or screening, last_trials=trials)
        step = _decide(state, len(found))
        taken = accept(state, step, progress) if step else None
        if taken is None:
            break
        before, known = state.cost, len(state.steps)
        state = absorb(drop_superfluous(swap(taken, progress), progress), progress)
        if len(state.steps) <= known and before - state.cost < worth(before):
            break  # it has left again, or another for it, and the constants are not much better for it
    return state


def _trials(state: GateSearch, plain: Base, screening: Screening, progress: Progress) -> list[Trial]:
    """Fit the candidates that passed the screening, best signatures first; those that help most once more about their own states."""
    others = [] if state.steps else [state.nominal]  # constants torn away by the missing effect are a bad place to start from

    def again(trial: Trial) -> Trial:
        own = own_trial(state.base, trial, others)
        progress(f"  {own.candidate.label}, own initial states: hold-out {own.cost:.4g} noise floors, t = {own.t:.1f}")
        return own

    kept = screening.kept()
    with ThreadPoolExecutor(state.workers) as pool:
        trials, solved = _first_trials(plain, kept, pool, progress)
        strong = _contenders(trials, screening, solved)
        weak = [trial for trial in trials if all(trial is not other for other in strong)]
        trials = [*weak, *pool.map(again, strong)]
    if any(trial.gain >= NEARLY_ALL for trial in trials):
        return trials
    for trial in reversed_trials(state.base, [s.candidate for s in kept], state.channels, others):
        progress(f"  {trial.candidate.label}, sign of {trial.beside.where if trial.beside else ''} reversed: {trial.cost:.4g} noise floors")
        trials.append(trial)
    return trials


def _first_trials(plain: Base, kept: Sequence[Signature], pool: Executor, progress: Progress) -> tuple[list[Trial], bool]:
    """The candidates beside the plain constants; whether one of the first wave solves the gap: those whose signature has hardly any of the
    gap need no fit then."""
    most, rough = max((s.share for s in kept), default=0.0), plain.rough

    def first(signature: Signature) -> Trial:
        trial = first_trial(rough, signature.candidate, signature.starts)
        progress(f"  {trial.candidate.label}: hold-out {plain.cost:.4g} → {trial.cost:.4g} noise floors, t = {trial.t:.1f}")
        return trial

    trials = list(pool.map(first, kept[:FIRST_WAVE]))
    solved = any(trial.gain >= MOST for trial in trials)
    trials += pool.map(first, [s for s in kept[FIRST_WAVE:] if not (solved and s.share < HARDLY * most)])
    return trials, solved


def _contenders(trials: Sequence[Trial], screening: Screening, solved: bool) -> list[Trial]:
    """First trials near the best, and whatever they gave those of the leading signatures: of the best trial's own signature where that one
    solves the gap (a first fit of two numbers may end far off where one number does), else of the first in the order."""
    best = max(trials, key=lambda trial: trial.gain)
    chosen = best.candidate
    leading = screening.same_direction(chosen.effect, chosen.where) if solved else [s.candidate for s in screening.kept()[:LEADING]]
    labels = {candidate.label for candidate in leading}
    enough = max(0.5 * LEAST_GAIN, CONTENDER * best.gain)
    return [trial for trial in trials if trial.gain >= enough or trial.candidate.label in labels]


def least_t(tried: int) -> float:
    """The t that one of so many candidates needs, so that a whole search rarely finds what is not there."""
    return max(LEAST_T, float(norm.isf(FALSE_ALARM / (3 * max(tried, 1)))))


def passes(t: float, gain: float, drop: float, least: float) -> bool:
    """Whether enough windows agree and the gain is worth an effect."""
    return t > _needed_t(gain, drop, least) and gain >= LEAST_GAIN and drop >= LEAST_DROP


def _needed_t(gain: float, drop: float, least: float) -> float:
    """A gap that stands in a few windows has few that can agree, and friction of another form costs votes everywhere: what takes all of a
    gap, or half of a plain one and leaves little, needs fewer."""
    if gain >= NEARLY_ALL:
        return CLOSING_T
    if gain <= LEAST_GAIN or drop < PLAIN_DROP or drop * (1.0 / gain - 1.0) > LEFT:
        return least
    share = min((gain - LEAST_GAIN) / (HALF - LEAST_GAIN), 1.0)
    return least - share * max(least - HALF_T, 0.0)


def _decide(state: GateSearch, tried: int) -> Step | None:
    """The best candidate that passes all gates, or None."""
    least = least_t(tried)
    passed = [t for t in state.last_trials if t.own and t.has_size and passes(t.t, t.gain, t.drop, least)]
    return _best_of(passed, state.last_trials) if passed else None


def _best_of(passed: Sequence[Trial], every: Sequence[Trial]) -> Step:
    """The best of those that passed the gates, with those that gain nearly as much and that the hold-out cannot tell from it."""
    best = min(passed, key=lambda trial: trial.cost)
    near = [t for t in passed if t is not best and t.gain >= RIVAL_GAIN * best.gain]
    return step_of(best, [t for t in near if separation_t(t.holdout, best.holdout) < RIVAL_T], every)


def step_of(best: Trial, rivals: Sequence[Trial], every: Sequence[Trial]) -> Step:
    """Of equals, the one with the fewest parameters is the name unless more are worth an effect."""
    plain = [t for t in rivals if t.cost - best.cost < worth(t.cost)]
    simplest = min([best, *plain], key=lambda t: (len(t.candidate.free), t.cost))
    equals = tuple(t for t in [best, *rivals] if t is not simplest)
    rest = tuple(t for t in every if t is not simplest and t not in equals)
    return Step(simplest.fit.model.added[-1], simplest, equals, rest)
