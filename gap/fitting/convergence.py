"""Fits taken on to their end: all numbers, the residual's correlation time, sensitivities and start states renewed on the way."""

from __future__ import annotations

from collections.abc import Sequence

from gap.data.windows import Experiment
from gap.fitting.evaluation import NO_GAP, Costing, Evaluation, mean_cost, recounted
from gap.fitting.fit import Fit, fit
from gap.fitting.model import Model
from gap.fitting.simulate import remembering

CONVERGED = 1e-3  # relative gain of a step: a base that has not converged would sell its rest to the next candidate
REFIT_STEPS = 8
SETTLINGS = 3
SAME_TAU = 0.7  # ratio of correlation times above which they are one
POLISHINGS, POLISH_STEPS = 4, 3
LITTLE = 0.05  # of the rig file's excess over the floor
ENDED = 0.1  # relative gain in excess over the floor below which polishing ends


def settled(done: Fit, experiments: Sequence[Experiment], costs: Costing, steps: int) -> tuple[Fit, Costing]:
    """All numbers fitted until the residual's correlation time is that of the model itself: while a model is wrong its residual is
    correlated over long times, and the data count for less than they should."""
    numbers = range(len(done.model.free))
    for _ in range(SETTLINGS):
        renewed = recounted(costs, done.evaluations)
        if renewed.tau > SAME_TAU * costs.tau:
            break
        costs = renewed
        known = [e.projection for e in done.evaluations]
        done = fit(done.model, experiments, costs, numbers, done.jacobian, steps, known, CONVERGED)
    return done, costs


def polished(done: Fit, nominal: Sequence[Evaluation], costs: Costing, good: float = NO_GAP) -> tuple[Fit, Costing]:
    """The fit taken on with sensitivities and start states of its own, where it has left little of a large gap: far from where they were
    taken, old ones end it beside the best place, and what is left there looks like a missing effect. `good`: cost of a fit that is left
    as it is."""
    for _ in range(POLISHINGS):
        if done.cost <= good or done.cost - 1.0 > LITTLE * (mean_cost(nominal) - 1.0):
            break
        vector = done.model.vector()
        experiments = [remembering(e.experiment, vector) for e in done.evaluations]
        further = fit(done.model, experiments, costs, range(len(done.model.free)), None, POLISH_STEPS, enough=CONVERGED)
        gained = done.cost - further.cost
        if gained > 0.0:
            done, costs = further, recounted(costs, further.evaluations)
        if gained < ENDED * max(done.cost - 1.0, NO_GAP - 1.0):
            break
    return done, costs


def whole_fit(start: Model, experiments: Sequence[Experiment], costs: Costing) -> Fit:
    """All numbers fitted from `start`, with sensitivities of their own."""
    return fit(start, experiments, costs, range(len(start.free)), None, REFIT_STEPS, enough=CONVERGED)


def fitted_to_its_end(
    start: Model, experiments: Sequence[Experiment], costs: Costing, nominal: Sequence[Evaluation]
) -> tuple[Fit, Costing]:
    """The same, and on from there with sensitivities and start states renewed."""
    return polished(whole_fit(start, experiments, costs), nominal, costs, 0.0)
