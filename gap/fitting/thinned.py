"""A fit seen through fewer of its windows: to rank effects and to size them half of the windows say what all of them do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gap.data.windows import Experiment
from gap.fitting.evaluation import Evaluation
from gap.fitting.fit import Fit

MOST_WINDOWS = 40  # of all fit logs together
TO_SIZE = 30  # fewer are enough to say how large an effect must be


def thinned(done: Fit, most: int = MOST_WINDOWS) -> tuple[Fit, float]:
    """The fit on every second (third …) run of neighbouring windows, and the share of the windows that is left.

    Only where windows are reached from kept states; else a simulation goes through the whole log, whatever is compared.
    """
    windows = sum(e.experiment.windows for e in done.evaluations)
    step = round(windows / most)
    if step < 2 or any(e.experiment.memory is None for e in done.evaluations):
        return done, 1.0
    kept = [_every(e.experiment, step) for e in done.evaluations]
    evaluations = tuple(_part(e, numbers) for e, numbers in zip(done.evaluations, kept, strict=True))
    jacobian = tuple(j[:, numbers] for j, numbers in zip(done.jacobian, kept, strict=True))
    columns = tuple(c[:, numbers] for c, numbers in zip(done.columns, kept, strict=True))
    return replace(done, evaluations=evaluations, jacobian=jacobian, columns=columns), sum(map(len, kept)) / windows


def _every(experiment: Experiment, step: int) -> NDArray[np.int64]:
    """Numbers of the windows in every `step`th run of neighbours; a run begins with an entry."""
    assert experiment.plan.entries is not None
    run = np.cumsum(experiment.plan.entries >= 0) - 1
    return np.flatnonzero(run % step == 0)


def _part(evaluation: Evaluation, numbers: Sequence[int] | NDArray[np.int64]) -> Evaluation:
    e = evaluation
    experiment = _windows(e.experiment, numbers)
    return replace(
        e,
        experiment=experiment,
        projection=e.projection.of_windows(numbers),
        readings=e.readings[numbers],
        left=e.left[numbers],
        window_costs=e.window_costs[numbers],
    )


def _windows(experiment: Experiment, numbers: Sequence[int] | NDArray[np.int64]) -> Experiment:
    plan, memory = experiment.plan, experiment.memory
    assert plan.entries is not None
    assert memory is not None
    fewer = replace(plan, starts=plan.starts[numbers], entries=plan.entries[numbers])
    return replace(experiment, plan=fewer, measured=experiment.measured[numbers], memory=replace(memory, states=memory.states[numbers]))
