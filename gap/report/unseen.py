"""A third log that neither fitted nor decided anything: the rig file as it was and as it was written, on fresh data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from config.errors import LogError
from config.loading.load import rig_from_text
from config.schema.rig import Rig
from gap.data.log_parts import load_parts
from gap.data.measured import Measured
from gap.data.windows import Experiment, prepare
from gap.fitting.evaluation import Costing, evaluate, mean_cost
from gap.fitting.model import Model
from gap.outcome.found import Found
from gap.report.bootstrap import cost_interval


@dataclass(frozen=True, slots=True)
class Unseen:
    """Costs of one log in noise floors, with 95 % intervals."""

    log: Measured
    before: float
    before_ci95: tuple[float, float]
    after: float
    after_ci95: tuple[float, float]

    def as_dict(self) -> dict[str, Any]:
        return {
            "file": self.log.path.name,
            "sha256": self.log.sha256,
            "before": self.before,
            "before_ci95": list(self.before_ci95),
            "after": self.after,
            "after_ci95": list(self.after_ci95),
        }


def unseen(found: Found, paths: Sequence[Path]) -> list[Unseen]:
    """Judge every log in the channels it has. LogError for one that the search has used."""
    return [_judged(found, log) for log in load_parts(paths, found.rig.rig)]


def _judged(found: Found, log: Measured) -> Unseen:
    used = {e.log.sha256: str(e.log.path) for e in (*found.state.experiments, *found.state.holdouts)}
    if log.sha256 in used:
        raise LogError("the log was used by the search", value=used[log.sha256], where=str(log.path), next_step="Give a log of its own.")
    experiment = _windows(found, log)
    improved = rig_from_text(found.improved_text, "improved rig.yaml")
    sides = [_cost(experiment, rig, found.state.costs) for rig in (found.rig.rig, improved)]
    return Unseen(log, *sides[0], *sides[1])


def _windows(found: Found, log: Measured) -> Experiment:
    like = found.state.holdouts[0]
    sigma = {name: float(like.sigma[k]) for k, name in enumerate(found.channels)}
    return prepare(log, found.rig.rig, sigma, like.plan.rows * like.plan.period_s, found.channels, like.workers)


def _cost(experiment: Experiment, rig: Rig, costs: Costing) -> tuple[float, tuple[float, float]]:
    evaluations = [evaluate(experiment, Model(rig, (), np.empty(0)), costs)]
    return mean_cost(evaluations), cost_interval(evaluations)
