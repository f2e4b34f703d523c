"""Explanations with what logs say of their numbers, where no search has just fitted them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from config.loading.load import LoadedRig
from gap.data.experiments import experiments_of
from gap.data.measured import Measured
from gap.data.strata import chosen
from gap.data.windows import velocities
from gap.fitting.evaluation import costing, evaluate, judged
from gap.fitting.fit import unfitted
from gap.fitting.simulate import remembering, some
from gap.maneuvers.earlier_logs import earlier_logs
from gap.maneuvers.separation import Rival
from gap.settings import Settings


def informed(loaded: LoadedRig, rivals: Sequence[Rival], logs: Sequence[Measured]) -> list[Rival]:
    """The numbers stand as fitted to these logs. The constants are felt by all rivals as by the first. LogError for logs too short."""
    model = rivals[0].model
    _, whole, _ = experiments_of(loaded, logs, [], Settings())
    numbers = chosen([velocities(e) for e in whole])
    few = [remembering(some(e, n), model.vector()) for e, n in zip(whole, numbers, strict=True)]
    now = [evaluate(e, model, None) for e in few]
    costs = costing(few, [e.left for e in now])
    done = unfitted(model, [judged(e.experiment, e.readings, e.projection, costs) for e in now], costs)
    return [replace(rival, earlier=earlier_logs(rival.model, done, costs)) for rival in rivals]
