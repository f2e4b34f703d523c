"""Where the refitted constants leave their priors: the search from constants that stay near their own.

A constant several standard deviations from what was known of it is an alarm about the structure, not a calibration: it does
what the missing effect should, and hides the effect's signature. Held near their priors, the constants leave it to be seen.
"""

from __future__ import annotations

from dataclasses import replace

from config.progress import Progress
from gap.fitting.convergence import CONVERGED, REFIT_STEPS, polished, settled
from gap.fitting.evaluation import NO_GAP, evaluate, recounted
from gap.fitting.fit import Fit, fit
from gap.fitting.model import Free, Model
from gap.fitting.nuisance import HONEST
from gap.search.acceptance import refit
from gap.search.joint_fits import look_jointly
from gap.search.search_state import GateSearch
from gap.search.select import search
from gap.search.verdict import alarmed

AS_GOOD_AS_STRAINED = 1.05  # hold-out with the effect over that with the strained constants …
NOT_MUCH_WORSE = 1.25  # … and where else nothing would be named: the name is tentative then, with the constants that would do as much


def search_held_at_priors(state: GateSearch, progress: Progress) -> GateSearch:
    """The search from the refitted constants; where these left their priors, from constants held near them if that explains as much."""
    if not alarmed(state.current):
        state = _taken_on(state, progress)
    if not alarmed(state.current):
        return search(state, progress)
    found = _let_go(search(_taken_on(_near_own(state, progress), progress), progress), state.nominal.model, progress)
    if found.cost > NO_GAP:
        state = _taken_on(state, progress)
    if found.cost > AS_GOOD_AS_STRAINED * max(state.cost, NO_GAP):
        return replace(search(state, progress), held=True)
    other = search(state, progress) if alarmed(found.current) else None
    return replace(other, held=True) if other is not None and other.cost <= found.cost else _instead(found, state)


def look_held_at_priors(state: GateSearch, progress: Progress) -> GateSearch:
    """Before nothing is named: constants may also have left their priors when they were fitted on, where the search no longer asked."""
    if state.steps or state.held or not alarmed(state.current):
        return state
    held = look_jointly(search(_taken_on(_near_own(state, progress), progress), progress), progress)
    found = _let_go(held, state.nominal.model, progress) if held.steps else held
    explains = bool(found.steps) and found.cost <= NOT_MUCH_WORSE * max(state.cost, NO_GAP)
    return _instead(found, state) if explains else state


def _near_own(state: GateSearch, progress: Progress) -> GateSearch:
    """Constants fitted near the rig file's own, where they may not do what a missing effect should."""
    progress(
        f"beyond their priors: {', '.join(alarmed(state.current))}; searching with every constant within {HONEST:g} standard deviations"
    )
    held = _held(state)
    progress(f"hold-out with constants so held: {held.cost:.4g} noise floors")
    return held


def _instead(found: GateSearch, strained: GateSearch) -> GateSearch:
    """The search within the priors as the answer, beside what the strained constants explain without any effect."""
    stands_in = bool(found.steps) and strained.cost <= AS_GOOD_AS_STRAINED * max(found.cost, NO_GAP)
    only = strained.constants_only if found.steps else found.seen
    keys = tuple(alarmed(strained.current)) if stands_in else ()
    return replace(found, nominal=strained.nominal, strained=keys, constants_only=only, held=True)


def _let_go(found: GateSearch, own: Model, progress: Progress) -> GateSearch:
    """The finished search with the constants' own bounds again. They are fitted once more where the holding had stopped one, unless they
    only leave their priors again for it and gain nothing."""
    held_back = _held_back(found.current.model, own)
    found = replace(found, current=_unbounded(found.current, own))
    if not (found.steps and held_back):
        return found
    freed = refit(found, found.current, progress)
    gains = found.cost > AS_GOOD_AS_STRAINED * max(freed.cost, NO_GAP)
    return freed if gains or (not alarmed(freed.current) and freed.cost <= found.cost) else found


def _taken_on(state: GateSearch, progress: Progress) -> GateSearch:
    """The constants' fit taken on where it may not have come to its end; also a good one that does not predict the hold-out as well."""
    good = NO_GAP if state.cost <= NO_GAP else 0.0
    done, costs = polished(state.current, state.nominal.evaluations, state.costs, good)
    if done is state.current:
        return state
    seen = tuple(evaluate(e, done.model, costs) for e in state.holdouts)
    further = replace(
        state, experiments=[e.experiment for e in done.evaluations], costs=costs, current=done, seen=seen, constants_only=seen
    )
    progress(f"constants fitted further: hold-out {state.cost:.4g} → {further.cost:.4g} noise floors")
    return further


def _held(state: GateSearch) -> GateSearch:
    """A search that begins at the rig file's own constants and keeps them near."""
    own = state.nominal
    model = replace(own.model, free=tuple(_near(free) for free in own.model.free))
    experiments = [e.experiment for e in own.evaluations]
    costs = recounted(replace(state.costs, caution=1.0), own.evaluations)
    known = [e.projection for e in own.evaluations]
    numbers = range(len(model.free))
    done = fit(model, experiments, costs, numbers, own.jacobian, REFIT_STEPS, known, CONVERGED)
    done, costs = settled(done, experiments, costs, REFIT_STEPS)
    seen = tuple(evaluate(e, done.model, costs) for e in state.holdouts)
    return GateSearch(experiments, state.holdouts, costs, state.channels, replace(own, model=model), done, seen, seen, state.workers)


def _near(free: Free) -> Free:
    if not free.prior:
        return free
    way = HONEST * free.scale
    return replace(free, low=max(free.low, free.start - way), high=min(free.high, free.start + way))


def _held_back(done: Model, own: Model) -> bool:
    """Whether a constant stands where only the holding stopped it; else the fit is that of the free constants too."""
    bounds = zip(done.theta, done.free, own.free, strict=False)  # the parameters of effects stand behind the constants
    return any(value == held.low > free.low or value == held.high < free.high for value, held, free in bounds)


def _unbounded(done: Fit, own: Model) -> Fit:
    """The same fit with the constants' own bounds; they stand before the parameters of effects."""
    return replace(done, model=replace(done.model, free=(*own.free, *done.model.free[len(own.free) :])))
