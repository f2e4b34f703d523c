"""A search that has ended on the single axis: the friction that was taken away is accepted, beside it an effect that the truth has not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from config.loading.load import LoadedRig, rig_from_text
from gap.data.measured import load
from gap.fitting.evaluation import evaluate
from gap.fitting.fit import Fit, unfitted
from gap.fitting.model import Model
from gap.fitting.nuisance import nuisances
from gap.search.opening import experiments_of, started
from gap.search.search_state import GateSearch, Step
from gap.search.settings import Settings
from gap.search.trial import Trial
from gap.signatures.candidates import Candidate, candidates
from tests.support.gap import axis_logs

MODEL = axis_logs.axis_text("coulomb_friction")


def quiet(line: str) -> None:
    """No progress."""


def finished(folder: Path, size: float, second: str = "valve_deadband", text: str = MODEL) -> GateSearch:
    """`size` of the `second` name's parameter, in the model only. `text`: the rig file."""
    truth = axis_logs.axis_rig()
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    logs = [load(axis_logs.write(folder / f"{s}.csv", axis_logs.simulated(truth, s, 5.0)), loaded.rig) for s in (1, 2)]
    names, few, held = experiments_of(loaded, logs[:1], logs[1:], Settings(propose=False))
    free = nuisances(loaded, frozenset(names))
    model = Model(loaded.rig, free, np.array([item.start for item in free]))
    begun = started(model, few, held, frozenset(names), quiet)[0]
    found = {c.effect: c for c in candidates(loaded.rig, frozenset(names))}
    friction = with_effect(model, found["coulomb_friction"], 20.39)
    both = with_effect(friction, found[second], size)
    rival = with_effect(model, found["valve_deadband"], 0.05)
    others = (trial(begun, found["valve_deadband"], rival), trial(begun, found["coulomb_friction"], friction))
    first = Step(both.added[0], trial(begun, found["coulomb_friction"], friction), (), others[:1])
    second = Step(both.added[1], trial(begun, found[second], both), (), ())
    current = fitted(begun, both)
    seen = tuple(evaluate(e, both, begun.costs) for e in held)
    return replace(begun, current=current, seen=seen, steps=(first, second))


def with_effect(model: Model, candidate: Candidate, value: float) -> Model:
    grown = model.with_effect(candidate.entry, candidate.free)
    return grown.with_theta(np.concatenate([model.theta, [value]]))


def fitted(state: GateSearch, model: Model) -> Fit:
    return unfitted(model, [evaluate(e, model, state.costs) for e in state.experiments], state.costs)


def trial(state: GateSearch, candidate: Candidate, model: Model) -> Trial:
    done = fitted(state, model)
    return Trial(candidate, done, tuple(evaluate(e, model, state.costs) for e in state.holdouts), 0.9, 1.0, 9.0, True, own=True)
