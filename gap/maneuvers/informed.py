"""Explanations with what logs say of their numbers, where no search has just fitted them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from config.loading.load import LoadedRig
from gap.data.experiments import experiments_of
from gap.data.measured import Measured
from gap.fitting.evaluation import first_costs
from gap.fitting.fit import unfitted
from gap.fitting.simulate import chosen_windows
from gap.maneuvers.earlier_logs import earlier_logs
from gap.maneuvers.separation import Rival
from gap.settings import Settings


def informed(loaded: LoadedRig, rivals: Sequence[Rival], logs: Sequence[Measured]) -> list[Rival]:
    """The numbers stand as fitted to these logs. The constants are felt by all rivals as by the first. LogError for logs too short."""
    model = rivals[0].model
    _, whole, _ = experiments_of(loaded, logs, [], Settings())
    costs, now = first_costs(chosen_windows(whole, model.vector()), model)
    done = unfitted(model, now, costs)
    return [replace(rival, earlier=earlier_logs(rival.model, done, costs)) for rival in rivals]
