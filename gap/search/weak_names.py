"""Names that stay tentative even where the gap is closed: an effect whose size the finished model does not know, or that it hardly needs.

Of several effects the first may close the gap and the next take what a wrong constant or friction of another form has left; the verdict,
which weighs all of them together, would vouch for each (seen in the blind study: a null bias of −1.4e-3, 95 % −3.5e-3 to 0.6e-3). And it
weighs them against constants whose fit may have ended beside the best place.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from config.progress import Progress
from gap.data.measured import Array
from gap.fitting.evaluation import NO_GAP, mean_cost
from gap.search.acceptance import without
from gap.search.search_state import GateSearch, Step
from gap.search.trial import FLOOR, clear_of_neutral, sized_by
from gap.search.verdict import CLEAR, CLOSED


def weighed(state: GateSearch, half_width: Array, progress: Progress) -> GateSearch:
    """The search with why each of its names is weak, if it is, where the gap is closed. `half_width`: 95 %, of every free number."""
    if state.cost > CLOSED:
        return state
    found = tuple(replace(step, weak=step.weak or _unsized(state, step, half_width) or _unneeded(state, step)) for step in state.steps)
    for step in found:
        if step.weak:
            progress(f"tentative: {step.trial.candidate.label} {step.weak}")
    return replace(state, steps=found)


def _unsized(state: GateSearch, step: Step, half_width: Array) -> str:
    """Its neutral value lies in the interval of every one of its parameters."""
    model = state.current.model
    if clear_of_neutral(model, step.entry, half_width):
        return ""
    k = sized_by(model, step.entry)[0]
    low, high = np.array([-1.0, 1.0]) * half_width[k] + model.theta[k]
    return f"may be nothing ({model.free[k].key} {low:.3g} to {high:.3g} {model.free[k].unit}".rstrip() + ")"


def _unneeded(state: GateSearch, step: Step) -> str:
    """The constants, fitted on from where it has brought them, and the other effects leave not much more without it."""
    _, rest = without(state, step.entry)
    if rest is None:
        return ""
    left = mean_cost(rest.seen)
    needed = left > NO_GAP and state.cost - FLOOR <= CLEAR * (left - FLOOR)
    return "" if needed else f"is hardly needed (hold-out without it {left:.3g})"
