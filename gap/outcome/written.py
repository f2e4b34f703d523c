"""The rig file that is written: with the names and the constants found beside them. Where the gap stays unknown it has the best constants
and no names."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from config.loading.load import LoadedRig, rig_from_text
from gap.fitting.evaluation import Evaluation, evaluate, mean_cost
from gap.fitting.model import Model
from gap.outcome.model_file import effect_line, improved
from gap.outcome.names import Fitted, Named
from gap.outcome.search_state import SearchState
from gap.outcome.verdict import Verdict
from gap.suspects.candidates import Candidate

COST_AS_GOOD = 1.03  # ratio of hold-out costs up to which the file as it was is preferred


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
    state: SearchState
    fitted: Fitted
    nominal: tuple[Evaluation, ...]
    alone: Model | None = None

    def file(self, word: Verdict) -> ImprovedFile:
        """The file as it was, with the names and constants of `fitted`, or with the best constants alone."""
        if word.word in ("no_gap", "data_problem"):
            return self.unchanged()
        if word.word == "unknown":
            return self._constants_alone()
        return self._with_names()

    def unchanged(self) -> ImprovedFile:
        """The file as it was."""
        return ImprovedFile(self.loaded.text, Model(self.loaded.rig, (), np.empty(0)), self.nominal)

    def _with_names(self) -> ImprovedFile:
        lines = [self._line(name, name.suspect) for name in self.state.named if isinstance(name.suspect, Candidate)]
        text = improved(self.loaded.text, self.fitted.model, lines)
        return ImprovedFile(text, self.fitted.model, again(self.state, file_model(text)))

    def _line(self, name: Named, effect: Candidate) -> str:
        grade, gap = "confirmed" if name.confirmed else "tentative", f"{mean_cost(self.nominal):.4g} to {self.state.cost:.4g} noise floors"
        return effect_line(effect, self.fitted, f"longreach gap find, {grade}: hold-out {gap}")

    def _constants_alone(self) -> ImprovedFile:
        """The file as it was where the best constants predict the hold-out no better."""
        model = self.alone or self.fitted.model
        text = improved(self.loaded.text, model, ())
        file = ImprovedFile(text, model, again(self.state, file_model(text)))
        return file if COST_AS_GOOD * file.cost < mean_cost(self.nominal) else self.unchanged()


def file_model(text: str) -> Model:
    """The file as it was written, nothing free: what is reported is what the file does."""
    return Model(rig_from_text(text, "improved rig.yaml"), (), np.empty(0))


def again(state: SearchState, model: Model) -> tuple[Evaluation, ...]:
    """A model near the final one on the hold-out, start states taken out as for the final one."""
    return tuple(evaluate(seen.experiment, model, state.costs, seen.projection) for seen in state.seen)
