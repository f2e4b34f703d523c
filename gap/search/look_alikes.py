"""Which effects a search has not told apart from the one it chose."""

from __future__ import annotations

from gap.fitting.compare import paired_t
from gap.search.search_state import RIVAL_GAIN, RIVAL_T, GateSearch, Step
from gap.search.trial import FLOOR, Trial

AS_NEAR = 1.10  # ratio of hold-out costs: an effect of the same signature that gets as near the floor is not excluded by its t alone


def look_alikes(state: GateSearch, step: Step) -> list[Trial]:
    """The step's rivals, and effects whose signature points the same way as long as the hold-out is not clearly against them; also those
    that were not accepted for want of a size, as a lag whose two numbers take each other's place: what they take together is no less."""
    chosen = step.trial
    before = chosen.cost + chosen.drop
    others = [
        trial.beside_cost(before, trial.t) for trial in _same_direction(state, step) if before - trial.cost >= RIVAL_GAIN * chosen.drop
    ]
    return [*step.rivals, *(trial for trial in others if _as_good(trial, chosen))]


def _same_direction(state: GateSearch, step: Step) -> list[Trial]:
    """Fitted candidates whose signature before any fit was that of the chosen one."""
    if state.first_screening is None or step is not state.steps[0]:
        return []
    fitted = {(t.candidate.effect, t.candidate.where): t for t in step.others}
    chosen = step.trial.candidate
    same = state.first_screening.same_direction(chosen.effect, chosen.where)
    return [fitted[(c.effect, c.where)] for c in same if (c.effect, c.where) in fitted]


def _as_good(trial: Trial, chosen: Trial) -> bool:
    return trial.cost <= AS_NEAR * max(chosen.cost, FLOOR) or paired_t(trial.holdout, chosen.holdout) < RIVAL_T
