"""A search as outcome and report see it: the model that is said and constants alone, fitted and on the hold-out, and the effects named."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from config.progress import Progress
from gap.data.coarse_steps import CoarseStep
from gap.data.windows import Experiment
from gap.fitting.evaluation import Costing, Evaluation, first_costs, mean_cost
from gap.fitting.fit import Fit, objective
from gap.fitting.model import Model
from gap.fitting.simulate import chosen_windows
from gap.outcome.names import Named


@dataclass(frozen=True, slots=True)
class SearchState:
    """`nominal`: the rig file's own constants; `current`: the model that is said, `seen`: the hold-out with it; `alone`: the best constants
    and no effect added, `alone_seen`: the hold-out with these. `judging`: those of the hold-out's windows that names are judged by; costs
    are over all of them."""

    experiments: Sequence[Experiment]
    holdouts: Sequence[Experiment]
    judging: Sequence[Experiment]
    costs: Costing
    channels: frozenset[str]
    nominal: Model
    current: Fit
    seen: tuple[Evaluation, ...]
    alone: Fit
    alone_seen: tuple[Evaluation, ...]
    named: tuple[Named, ...] = ()
    coarse: tuple[CoarseStep, ...] = ()  # readings in steps that the rig file does not have, seen in the data themselves

    @property
    def cost(self) -> float:
        return mean_cost(self.seen)

    @property
    def without_names(self) -> SearchState:
        """The same with constants alone."""
        return replace(self, current=self.alone, seen=self.alone_seen, named=())


def opening_state(
    model: Model, experiments: list[Experiment], held: list[Experiment], channels: frozenset[str], progress: Progress
) -> SearchState:
    """The rig file as it is, on the fit logs' chosen windows and on the hold-out; nothing is fitted yet."""
    progress("comparing the rig file with the logs")
    few, judging = (chosen_windows(logs, model.vector()) for logs in (experiments, held))
    costs, counted = first_costs([*few, *held], model)
    now, nominal = tuple(counted[: len(few)]), tuple(counted[len(few) :])
    progress(f"hold-out: {mean_cost(nominal):.4g} noise floors")
    start = Fit(model, now, (), (), objective(model, now, costs))
    return SearchState(few, held, judging, costs, channels, model, start, nominal, start, nominal)
