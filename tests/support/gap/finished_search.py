"""A search that has ended on the single axis: the friction that was taken away is named, beside it an effect that the truth has not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from config.loading.load import LoadedRig, rig_from_text
from gap.data.experiments import experiments_of
from gap.data.measured import load
from gap.fitting.evaluation import evaluate
from gap.fitting.fit import Fit, unfitted
from gap.fitting.model import Model
from gap.fitting.nuisance import nuisances
from gap.outcome.names import Explanation, Named
from gap.outcome.search_state import SearchState, opening_state
from gap.settings import Settings
from gap.suspects.candidates import Candidate, candidates
from tests.support.gap import axis_logs

MODEL = axis_logs.axis_text("coulomb_friction")


def quiet(line: str) -> None:
    """No progress."""


def finished(folder: Path, size: float, second: str = "valve_deadband", text: str = MODEL) -> SearchState:
    """`size` of the `second` name's parameter, in the model only. `text`: the rig file."""
    truth = axis_logs.axis_rig()
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    logs = [load(axis_logs.write(folder / f"{s}.csv", axis_logs.simulated(truth, s, 5.0)), loaded.rig) for s in (1, 2)]
    names, few, held = experiments_of(loaded, logs[:1], logs[1:], Settings(propose=False))
    free = nuisances(loaded, frozenset(names))
    model = Model(loaded.rig, free, np.array([item.start for item in free]))
    begun = opening_state(model, few, held, frozenset(names), quiet)
    found = {c.effect: c for c in candidates(loaded.rig, frozenset(names))}
    friction = with_effect(model, found["coulomb_friction"], 20.39)
    both = with_effect(friction, found[second], size)
    first, other = (named(begun, found[effect], both) for effect in ("coulomb_friction", second))
    return replace(begun, current=fitted(begun, both), seen=first.explanation.holdout, named=(first, other))


def with_effect(model: Model, candidate: Candidate, value: float) -> Model:
    grown = model.with_effect(candidate.entry, candidate.free)
    return grown.with_theta(np.concatenate([model.theta, [value]]))


def fitted(state: SearchState, model: Model) -> Fit:
    return unfitted(model, [evaluate(e, model, state.costs) for e in state.experiments], state.costs)


def named(state: SearchState, candidate: Candidate, model: Model) -> Named:
    seen = tuple(evaluate(e, model, state.costs) for e in state.holdouts)
    return Named(Explanation(candidate, fitted(state, model), seen, state.seen, 0.9, 9.0), 1.0, True, None, ())
