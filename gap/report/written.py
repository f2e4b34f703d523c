"""The model that is written: the fewest changes that predict the hold-out as well as all of them, and the rig file with these."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from config.load import LoadedRig, rig_from_text
from gap.data.measured import Array
from gap.fitting.evaluation import Evaluation, evaluate, mean_cost
from gap.fitting.fit import fit
from gap.fitting.model import Model
from gap.report.model_file import improved, moved, width_key
from gap.search.search_state import Search
from gap.search.trial import FLOOR, effects
from gap.search.verdict import Verdict

ALIKE = 1.03  # ratio of hold-out costs up to which the model with fewer changes is preferred
Tell = Callable[[str], None]


def widths_of(state: Search, half_width: Array) -> dict[str, float]:
    """95% half widths of the effects' parameters by name."""
    model = state.current.model
    return {width_key(s, model.free[k].key): float(half_width[k]) for s in state.steps for k in model.of_effect(s.entry)}


def leanest(state: Search, half_width: Array, tell: Tell) -> Model:
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
        if done and reached <= max(ALIKE * state.cost, FLOOR):
            tell(f"{len(numbers) - len(sizes)} changed constants suffice: hold-out {reached:.4g} noise floors")
            return done.model
    return model


def changed(model: Model, lean: Model, half_width: Array) -> list[int]:
    """Numbers of the constants that the data moved and that the written model has at other values."""
    kept = {free.key for free in lean.free}
    return [k for k in moved(model, half_width) if model.free[k].key in kept]


def text_of(loaded: LoadedRig, state: Search, draft: Verdict, lean: Model, widths: dict[str, float], before: float) -> str:
    if draft.word in ("no_gap", "data_problem") or (draft.word == "unknown" and not state.steps):
        return loaded.text
    grades = ["confirmed" if draft.confirmed and not step.weak else "tentative" for step in state.steps]
    remarks = [f"longreach gap find, {grade}: hold-out {before:.4g} to {state.cost:.4g} noise floors" for grade in grades]
    return improved(loaded.text, lean, state.steps, widths, remarks)


def file_model(text: str) -> Model:
    """The file as it was written, nothing free: what is reported is what the file does."""
    return Model(rig_from_text(text, "improved rig.yaml"), (), np.empty(0))


def again(state: Search, model: Model) -> tuple[Evaluation, ...]:
    """A model near the final one on the hold-out, start states taken out as for the final one."""
    return tuple(evaluate(seen.experiment, model, state.costs, seen.projection) for seen in state.seen)
