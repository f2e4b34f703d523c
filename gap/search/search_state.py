"""What a search by gates knows at one moment: its model and the effects it has accepted, each with its rivals.

Nothing in it changes: a step takes a GateSearch and returns another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from config.schema.effect_entry import EffectEntry
from gap.data.coarse_steps import CoarseStep
from gap.data.windows import Experiment
from gap.fitting.evaluation import Costing, Evaluation, mean_cost
from gap.fitting.fit import Fit
from gap.search.trial import FLOOR, LEAST_GAIN, Base, Trial
from gap.signatures.screen import VISIBLE, Screening

LEAST_T = 3.5
LEAST_DROP = 0.02  # noise floors
RIVAL_T = 3.0
RIVAL_GAIN = 0.8


def worth(cost: float) -> float:
    """The least that an effect must take from a cost, in noise floors."""
    return max(LEAST_DROP, LEAST_GAIN * (cost - FLOOR))


@dataclass(frozen=True, slots=True)
class Step:
    """One accepted effect with its rivals: candidates the hold-out cannot tell from it."""

    entry: EffectEntry
    trial: Trial
    rivals: tuple[Trial, ...]
    others: tuple[Trial, ...]
    weak: str = ""  # why the name stays tentative even where the gap is closed


@dataclass(frozen=True, slots=True)
class Rest:
    """What is left of the model `of` without one of its effects: fitted again, and on the hold-out."""

    of: Fit
    entry: EffectEntry
    fit: Fit
    seen: tuple[Evaluation, ...]


@dataclass(frozen=True, slots=True)
class GateSearch:
    """One moment of a search, between the refitted nominal model and the final one."""

    experiments: Sequence[Experiment]
    holdouts: Sequence[Experiment]
    costs: Costing
    channels: frozenset[str]
    nominal: Fit  # the rig file's own constants
    current: Fit
    seen: tuple[Evaluation, ...]  # hold-out with the current model
    constants_only: tuple[Evaluation, ...]  # hold-out with the best constants, and no effect added
    workers: int = 1
    steps: tuple[Step, ...] = ()
    screening: Screening | None = None
    first_screening: Screening | None = None
    last_trials: tuple[Trial, ...] = ()
    coarse: tuple[CoarseStep, ...] = ()  # readings in steps that the rig file does not have, seen in the data themselves
    rests: tuple[Rest, ...] = ()
    held: bool = False  # constants held near their own have been tried
    strained: tuple[str, ...] = ()  # constants that would explain the gap without the effects, far beyond their priors

    @property
    def cost(self) -> float:
        return mean_cost(self.seen)

    @property
    def least_drop(self) -> float:
        """The smallest fall of the hold-out's cost with which a candidate passes all gates. That of t: a fall that is even over the
        hold-out is known no better than the mean of its N values, √(2/N)."""
        values = sum(int(np.isfinite(e.measured).sum()) for e in self.holdouts)
        return max(worth(self.cost), LEAST_T * float(np.sqrt(2.0 / values)))

    @property
    def seen_at(self) -> float:
        """Energy of a signature on the fit logs at which its effect would be named."""
        values = sum(int(np.isfinite(e.measured).sum()) for e in self.experiments)
        return max(VISIBLE**2 * self.costs.tau, self.least_drop * values)

    @property
    def base(self) -> Base:
        return Base(self.experiments, self.holdouts, self.costs, self.current, self.seen)

    def with_step(self, number: int, step: Step) -> GateSearch:
        """The search with another step in the place of one."""
        return replace(self, steps=(*self.steps[:number], step, *self.steps[number + 1 :]))

    def without_step(self, step: Step) -> GateSearch:
        """The search without one of its steps."""
        return replace(self, steps=tuple(other for other in self.steps if other is not step))
