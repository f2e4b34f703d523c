"""Which explanations a search leaves in doubt, and what the next maneuver between them is."""

from __future__ import annotations

from typing import Any

from config.loading.load import LoadedRig
from config.progress import Progress
from gap.maneuvers.earlier_logs import earlier_logs
from gap.maneuvers.next_maneuver import next_maneuver
from gap.maneuvers.rivals import MOST_RIVALS, NONE
from gap.maneuvers.separation import Rival
from gap.outcome.names import Explanation
from gap.outcome.search_state import SearchState
from gap.suspects.candidates import Candidate


def next_of(loaded: LoadedRig, state: SearchState, progress: Progress) -> dict[str, Any] | None:
    """For look-alikes and for tentative names; None when every name is confirmed or there is none."""
    rivals = doubtful(state)
    if not rivals:
        return None
    progress(f"which maneuver would separate {' and '.join(rival.name for rival in rivals)}?")
    found = next_maneuver(loaded, rivals, progress, sorted(state.channels), thorough=False)
    return found.as_dict() if found else None


def doubtful(state: SearchState) -> list[Rival]:
    """The first effect with look-alikes and the likeliest of them; without look-alikes, the last tentative one and the model without it. No
    maneuver is looked for between effects and changed numbers, which every explanation may change."""
    effects = [name for name in state.named if isinstance(name.suspect, Candidate)]
    for name in effects:
        alike = [one.explanation for one in name.look_alikes if isinstance(one.explanation.suspect, Candidate)]
        if alike:
            return [_rival(state, one) for one in (name.explanation, *alike)[:MOST_RIVALS]]
    tentative = [name.explanation for name in effects if not name.confirmed]
    return [_rival(state, tentative[-1]), _without(state, tentative[-1])] if tentative else []


def _without(state: SearchState, one: Explanation) -> Rival:
    """The model without the effect: that is fitted to no log, so none holds its numbers."""
    assert isinstance(one.suspect, Candidate)
    model, entry = one.fit.model, one.fit.model.entry_added(one.suspect.effect, one.suspect.where)
    return Rival(NONE, state.nominal if len(model.added) == 1 else model.without_effect(entry))


def _rival(state: SearchState, one: Explanation) -> Rival:
    model = one.fit.model
    return Rival(one.suspect.label, model, earlier_logs(model, state.current, state.costs))
