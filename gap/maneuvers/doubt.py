"""Which explanations a search leaves in doubt, and what the next maneuver between them is."""

from __future__ import annotations

from typing import Any

from config.loading.load import LoadedRig
from config.progress import Progress
from gap.maneuvers.earlier_logs import earlier_logs
from gap.maneuvers.next_maneuver import next_maneuver
from gap.maneuvers.rivals import MOST_RIVALS, NONE
from gap.maneuvers.separation import Rival
from gap.search.look_alikes import look_alikes
from gap.search.search_state import GateSearch, Step
from gap.search.trial import Trial
from gap.search.verdict import Verdict


def next_of(loaded: LoadedRig, state: GateSearch, word: Verdict, progress: Progress) -> dict[str, Any] | None:
    """For look-alikes and for tentative names; None when every name is confirmed or there is none."""
    rivals = doubtful(state, word)
    if not rivals:
        return None
    progress(f"which maneuver would separate {' and '.join(rival.name for rival in rivals)}?")
    found = next_maneuver(loaded, rivals, progress, sorted(state.channels), thorough=False)
    return found.as_dict() if found else None


def doubtful(state: GateSearch, word: Verdict) -> list[Rival]:
    """The first effect with look-alikes and the closest of them; without look-alikes, the last tentative one and its runner-up."""
    unclear = next(((step.trial, *alike) for step in state.steps if (alike := look_alikes(state, step))), None)
    if unclear is not None:
        return [_rival(state, trial) for trial in unclear[:MOST_RIVALS]]
    tentative = [step for step in state.steps if step.weak or not word.confirmed]
    if not tentative:
        return []
    last = tentative[-1]
    return [_rival(state, last.trial), _runner_up(state, last)]


def _runner_up(state: GateSearch, step: Step) -> Rival:
    """The next best explanation that was fitted, else the model without the effect: that is fitted to no log, so none holds its numbers."""
    others = [trial for trial in step.others if trial.gain > 0.0]
    if others:
        return _rival(state, min(others, key=lambda trial: trial.cost))
    before = state.nominal.model if step is state.steps[0] else step.trial.fit.model.without_effect(step.entry)
    return Rival(NONE, before)


def _rival(state: GateSearch, trial: Trial) -> Rival:
    model = trial.fit.model
    return Rival(trial.candidate.label, model, earlier_logs(model, state.current, state.costs))
