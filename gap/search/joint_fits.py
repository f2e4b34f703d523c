"""Before nothing is named: the best candidates fitted together with all constants, from the rig file's own.

Every trial so far began where constants fitted without the effect had ended, and those stand where they best do its work: a few steps lead
from there to the next best place, not back. From the rig file's own constants the effect and the constants compete on equal terms. What is
left of friction of another form is no noise, though, and constants that follow it closely predict another motion worse; so the data
count for less here, and the effect is asked for in the fit logs as well as in the hold-out, whose windows alone are few.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from config.progress import Progress
from gap.fitting.compare import paired_t
from gap.fitting.convergence import fitted_to_its_end, whole_fit
from gap.fitting.evaluation import Costing, evaluate, mean_cost
from gap.fitting.thinned import thinned
from gap.search.absorbed import absorb
from gap.search.acceptance import accept, drop_superfluous
from gap.search.search_state import LEAST_DROP, RIVAL_T, GateSearch, Step, worth
from gap.search.select import least_t, search, step_of
from gap.search.trial import FLOOR, Trial, excess, joint_trial
from gap.signatures.candidates import candidates
from gap.signatures.screen import Screening, screen

CAUTION = 4.0  # samples count as one over so many times the residual's correlation time
BEST = 3  # candidates by what their signatures explain of the rig file's own gap, constants answering within their priors …
KNOWN = 2  # … and by what they have left of it beside the refitted constants
ROUGH_WINDOWS = 20  # to which each of them is fitted first
FURTHER = 2  # of them, fitted to their end on all
HOLD_OUT_T = 0.5  # the hold-out must speak for the effect, if with fewer windows than would do by themselves
MOST_OPEN = 1.5  # noise floors above the floor that may be left, as friction of another form leaves them: more is no explanation …
MOST = 0.8  # … of a gap of which it does not take at least so much


def look_jointly(state: GateSearch, progress: Progress) -> GateSearch:
    """The search with an effect that only shows beside the rig file's own constants, and what may follow on it; else with these constants
    fitted more cautiously, where that predicts the hold-out better."""
    if state.steps or state.cost < FLOOR + LEAST_DROP:
        return state
    progress("nothing named; fitting the best candidates together with the constants, from the rig file's own")
    cautious = _cautious(state, progress)
    lowest = min((state, cautious), key=lambda one: one.cost)
    step = _step(state, cautious, lowest, progress)
    taken = accept(replace(cautious, constants_only=lowest.seen), step, progress) if step else None
    if taken is not None and lowest.cost - taken.cost >= worth(lowest.cost):
        needed = absorb(drop_superfluous(taken, progress), progress)
        if needed.steps:
            return search(needed, progress)
    return cautious if cautious.cost < state.cost - worth(state.cost) else state


def _step(state: GateSearch, cautious: GateSearch, lowest: GateSearch, progress: Progress) -> Step | None:
    """The best candidate that passes the gates beside both fits of the constants, or None."""
    found = candidates(state.nominal.model.rig, state.channels)
    screening = screen(state.nominal, state.costs, found, state.seen_at, progress)
    least, trials = least_t(len(found)), _trials(state, cautious, screening, progress)
    trials = [trial.beside_cost(lowest.cost, paired_t(lowest.seen, trial.holdout)) for trial in trials]
    passed = [trial for trial in trials if _agreed(trial, (state, cautious), least)]
    if not passed:
        return None
    best = min(passed, key=lambda trial: trial.cost)
    step = step_of(best, [t for t in passed if t is not best and paired_t(t.everywhere, best.everywhere) < RIVAL_T], trials)
    known = step.trial.t > least
    return step if known else replace(step, weak=f"rests on the fit logs more than on the hold-out (t = {step.trial.t:.1f} there)")


def _cautious(state: GateSearch, progress: Progress) -> GateSearch:
    """The constants alone, from the rig file's own."""
    costs = Costing(state.costs.threshold, CAUTION * state.costs.tau, CAUTION)
    experiments = [e.experiment for e in state.nominal.evaluations]
    done, costs = fitted_to_its_end(state.nominal.model, experiments, costs, state.nominal.evaluations)
    seen = tuple(evaluate(e, done.model, costs) for e in state.holdouts)
    progress(f"  constants alone: hold-out {mean_cost(seen):.4g} noise floors")
    return replace(state, experiments=experiments, costs=costs, current=done, seen=seen, constants_only=seen, rests=())


def _trials(state: GateSearch, cautious: GateSearch, screening: Screening, progress: Progress) -> list[Trial]:
    """All are fitted to some of the windows; those that then explain the fit logs best, to all."""
    known = sorted((t for t in state.last_trials if t.own and t.beside is None), key=lambda trial: trial.cost)[:KNOWN]
    labels = [trial.candidate.label for trial in known]
    asked = [s for k, s in enumerate(screening.signatures) if k < BEST or s.candidate.label in labels]
    some = [e.experiment for e in thinned(state.nominal, ROUGH_WINDOWS)[0].evaluations]
    first = []
    for signature in asked:
        start = whole_fit(signature.starts[0], some, cautious.costs)
        progress(f"  {signature.candidate.label}: {start.cost:.4g} noise floors of the fit logs")
        first.append((start.cost, signature.candidate, start.model))
    trials = []
    for _, candidate, model in sorted(first, key=lambda one: one[0])[:FURTHER]:
        trial = joint_trial(cautious.base, candidate, model, cautious.nominal)
        progress(f"  {candidate.label}, fitted further: hold-out {trial.cost:.4g} noise floors, t = {trial.t:.1f}")
        trials.append(trial)
    return trials


def _agreed(trial: Trial, without: Sequence[GateSearch], least: float) -> bool:
    """Whether fit logs and hold-out together, and the hold-out by itself, speak for the effect beside each of the constants' fits."""
    explains = excess(trial.cost) <= MOST_OPEN or trial.gain >= MOST
    if not (trial.has_size and explains and trial.drop >= max(worth(s.cost) for s in without)):
        return False
    for other in without:
        before = (*other.current.evaluations, *other.seen)
        if paired_t(before, trial.everywhere) <= least or paired_t(other.seen, trial.holdout) <= HOLD_OUT_T:
            return False
    return True
