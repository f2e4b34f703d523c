"""The rig file that is written: the fewest changes that predict the hold-out as well as all of them. Where the gap stays unknown it has
the best constants and no names."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from config.loading.load import LoadedRig, rig_from_text
from config.progress import Progress
from gap.data.measured import Array
from gap.fitting.convergence import fitted_to_its_end
from gap.fitting.evaluation import Evaluation, evaluate, mean_cost
from gap.fitting.fit import fit
from gap.fitting.model import Model
from gap.outcome.model_file import improved, moved, width_key
from gap.search.search_state import GateSearch
from gap.search.trial import FLOOR, effects
from gap.search.verdict import Verdict, confidence

COST_AS_GOOD = 1.03  # ratio of hold-out costs up to which the model with fewer changes is preferred


def widths_of(state: GateSearch, half_width: Array) -> dict[str, float]:
    """95% half widths of the effects' parameters by name."""
    model = state.current.model
    return {width_key(s, model.free[k].key): float(half_width[k]) for s in state.steps for k in model.of_effect(s.entry)}


def leanest(state: GateSearch, half_width: Array, progress: Progress) -> Model:
    """The model with the fewest changed constants that predicts the hold-out as well as the one with all of them."""
    model = state.current.model
    sizes = effects(model)
    some = sorted({*sizes, *moved(model, half_width)})
    for numbers in [sizes, some] if sizes else [some]:
        smaller = model.restricted(numbers)
        jacobian = [columns[numbers] for columns in state.current.jacobian]
        known = [e.projection for e in state.current.evaluations]
        done = fit(smaller, state.experiments, state.costs, range(len(numbers)), jacobian, 4, known) if numbers else None
        reached = mean_cost(again(state, done.model)) if done else np.inf
        if done and reached <= max(COST_AS_GOOD * state.cost, FLOOR):
            progress(f"{len(numbers) - len(sizes)} changed constants suffice: hold-out {reached:.4g} noise floors")
            return done.model
    return model


def changed(model: Model, lean: Model, half_width: Array) -> list[int]:
    """Numbers of the constants that the data moved and that the written model has at other values."""
    kept = {free.key for free in lean.free}
    return [k for k in moved(model, half_width) if model.free[k].key in kept]


@dataclass(frozen=True, slots=True)
class ImprovedFile:
    """The rig file as written, the model it came from (free: what it has at other values than before), and the hold-out with it."""

    text: str
    model: Model
    seen: tuple[Evaluation, ...]

    @property
    def cost(self) -> float:
        return mean_cost(self.seen)


@dataclass(frozen=True, slots=True)
class Writer:
    """Writes the improved rig file of a finished search, by its verdict. `nominal`: the hold-out with the file as it was; `alone`: the best
    constants without any name, where they are known."""

    loaded: LoadedRig
    state: GateSearch
    half_width: Array
    lean: Model
    nominal: tuple[Evaluation, ...]
    progress: Progress
    alone: Model | None = None

    def file(self, word: Verdict) -> ImprovedFile:
        """The file as it was, with the names and the constants of `lean`, or with the best constants alone."""
        if word.word in ("no_gap", "data_problem"):
            return self.unchanged()
        if word.word == "unknown":
            return self._constants_alone()
        return self._with_names(word)

    def unchanged(self) -> ImprovedFile:
        """The file as it was."""
        return ImprovedFile(self.loaded.text, Model(self.loaded.rig, (), np.empty(0)), self.nominal)

    def _with_names(self, word: Verdict) -> ImprovedFile:
        before, state = mean_cost(self.nominal), self.state
        grades = ["confirmed" if word.confirmed and not step.weak else "tentative" for step in state.steps]
        remarks = [f"longreach gap find, {grade}: hold-out {before:.4g} to {state.cost:.4g} noise floors" for grade in grades]
        text = improved(self.loaded.text, self.lean, state.steps, widths_of(state, self.half_width), remarks)
        return ImprovedFile(text, self.lean, again(state, file_model(text)))

    def _constants_alone(self) -> ImprovedFile:
        """The file as it was where the best constants predict the hold-out no better."""
        state, lean = self.state, self.alone or self.lean
        if state.steps and not self.alone:
            state = without_names(state)
            lean = leanest(state, confidence(state.current, state.costs), self.progress)
        text = improved(self.loaded.text, lean, (), {}, ())
        file = ImprovedFile(text, lean, again(state, file_model(text)))
        return file if COST_AS_GOOD * file.cost < mean_cost(self.nominal) else self.unchanged()


def without_names(state: GateSearch) -> GateSearch:
    """The search with constants alone, fitted to their end."""
    experiments = [e.experiment for e in state.nominal.evaluations]
    done, costs = fitted_to_its_end(state.nominal.model, experiments, state.costs, state.nominal.evaluations)
    seen = tuple(evaluate(e, done.model, costs) for e in state.holdouts)
    return replace(state, experiments=experiments, costs=costs, current=done, seen=seen, constants_only=seen, steps=(), rests=())


def file_model(text: str) -> Model:
    """The file as it was written, nothing free: what is reported is what the file does."""
    return Model(rig_from_text(text, "improved rig.yaml"), (), np.empty(0))


def again(state: GateSearch, model: Model) -> tuple[Evaluation, ...]:
    """A model near the final one on the hold-out, start states taken out as for the final one."""
    return tuple(evaluate(seen.experiment, model, state.costs, seen.projection) for seen in state.seen)
