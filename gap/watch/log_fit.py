"""One log by itself: its values of the watched numbers, beside all other constants within their priors.

The fit and its posterior covariance C are those of the search (`gap.fitting`). In units of the priors a posterior mean m is drawn towards
the rig file by (1 − C_ii); here that share is taken out again, so that many logs do not count one prior many times. Each number then has
two standard deviations: `sd`, of what the log alone says of it, the other constants anywhere within their priors, and `again_sd`, by
which it would differ if the machine did the same once more, C − C² and never less than what the windows' own votes say. A constant that
the rig file has wrong shifts all logs alike: it is in the first and not in the second.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from config.errors import LogError
from config.loading.load import LoadedRig
from gap.data.channel_check import comparable
from gap.data.data_check import DataProblem, check
from gap.data.experiments import experiments_of
from gap.data.measured import Array, Measured
from gap.data.windows import Experiment
from gap.fitting.confidence import bootstrap_sd
from gap.fitting.evaluation import Costing, Evaluation, first_costs, recounted
from gap.fitting.fit import CONVERGED, Fit, covariance, fit, full_step
from gap.fitting.model import Model
from gap.fitting.model_check import against_model
from gap.fitting.nuisance import nuisances
from gap.fitting.sensitivity import projected, sensitivities
from gap.fitting.simulate import chosen_windows, remembering
from gap.settings import Settings
from gap.watch.watched import watched, with_wide_priors

MOST_RENEWALS = 8
AT_ITS_END = 0.2  # posterior standard deviations that no number moves by any more
POINT = 2e-3  # of a prior standard deviation, by which a number is moved for a derivative at a point
TOLD = 0.9  # posterior over (wide) prior standard deviation above which a log does not tell a number


@dataclass(frozen=True, slots=True)
class FittedValue:
    """A number as one log has it, SI."""

    value: float
    sd: float
    again_sd: float


@dataclass(frozen=True, slots=True)
class LogFit:
    """`cost`: what the fitted constants leave, in noise floors. `values` by name, without those that the log does not tell."""

    cost: float
    values: dict[str, FittedValue]

    def as_dict(self) -> dict[str, Any]:
        return {"cost": self.cost, "values": {name: [v.value, v.sd, v.again_sd] for name, v in self.values.items()}}

    @classmethod
    def of(cls, content: dict[str, Any]) -> LogFit:
        return cls(float(content["cost"]), {name: FittedValue(*map(float, numbers)) for name, numbers in content["values"].items()})


def fit_log(loaded: LoadedRig, parts: Sequence[Measured], workers: int) -> LogFit:
    """The parts of one log (`gap.data.log_parts`) fitted. LogError where they cannot carry a comparison."""
    _refuse(check(parts, loaded.rig))
    logs = [comparable(part, loaded.rig) for part in parts]
    names, experiments, _ = experiments_of(loaded, logs, [], Settings(workers=workers))
    free = nuisances(loaded, frozenset(names))
    followed = watched(loaded.rig, free)
    model = Model(loaded.rig, with_wide_priors(free, followed), np.array([item.start for item in free]))
    few, costs, nominal = _opened(model, experiments)
    _refuse(against_model(nominal, names))
    done, costs = _fitted_on(fit(model, few, costs), costs)
    values, sds, again = _own(_at_a_point(done), costs)
    numbers = {item.key: k for k, item in enumerate(model.free)}
    told = {number.name: numbers[number.free.key] for number in followed}
    found = {name: FittedValue(float(values[k]), float(sds[k]), float(again[k])) for name, k in told.items() if np.isfinite(sds[k])}
    return LogFit(done.cost, found)


def _refuse(problems: Sequence[DataProblem]) -> None:
    fatal = [problem for problem in problems if problem.fatal]
    if fatal:
        place = f"{fatal[0].where}: {fatal[0].channel}" if fatal[0].channel else fatal[0].where
        raise LogError(fatal[0].what, where=place, next_step="Nothing about the plant can be told from this log.")


def _opened(model: Model, experiments: Sequence[Experiment]) -> tuple[list[Experiment], Costing, list[Evaluation]]:
    """Windows of every regime, and the rig file as it is on them."""
    few = chosen_windows(experiments, model.vector())
    return few, *first_costs(few, model)


def _fitted_on(done: Fit, costs: Costing) -> tuple[Fit, Costing]:
    """The fit taken on with start states and sensitivities of its own until they lead nowhere: a worn machine is far from its file."""
    for _ in range(MOST_RENEWALS):
        vector, costs = done.model.vector(), recounted(costs, done.evaluations)
        further = fit(done.model, [remembering(e.experiment, vector) for e in done.evaluations], costs)
        sds = np.sqrt(np.maximum(np.diag(covariance(further, costs)), 1e-300))
        moved = float(np.max(np.abs(further.model.theta - done.model.theta) / sds))
        done = further if further.cost < done.cost * (1.0 + CONVERGED) else done
        if moved < AT_ITS_END:
            break
    return done, recounted(costs, done.evaluations)


def _at_a_point(done: Fit) -> Fit:
    """The fit with derivatives where it ended. Those it was made with are secants over a third of a prior, brought along with its steps: of
    two numbers that do the same (rated flow, full scale of the command) they differ, and each would seem to be known."""
    experiments = [e.experiment for e in done.evaluations]
    numbers = range(len(done.model.free))
    jacobian = sensitivities(done.model, experiments, numbers, [e.readings for e in done.evaluations], np.full(len(numbers), POINT))
    columns = [projected(e, j) for e, j in zip(done.evaluations, jacobian, strict=True)]
    return replace(done, jacobian=tuple(jacobian), columns=tuple(columns))


def _own(done: Fit, costs: Costing) -> tuple[Array, Array, Array]:
    """Of every free number, in its unit: what the log alone says, its standard deviation (infinite where it says too little), and that of
    a repeat."""
    free, scales = done.model.free, done.model.scales
    start = np.array([item.start for item in free])
    c = covariance(done, costs) / np.outer(scales, scales)
    theta = np.clip(done.model.theta + full_step(done, costs)[0], [item.low for item in free], [item.high for item in free])
    moved, sds, again = alone(c, (theta - start) / scales, bootstrap_sd(done, costs) / scales)
    return start + scales * moved, scales * sds, scales * again


def alone(c: Array, moved: Array, votes_sd: Array) -> tuple[Array, Array, Array]:
    """The prior of each number itself taken out of a posterior with covariance `c` and mean `moved`, all in units of the priors.
    `votes_sd`: the least by which a repeat differs. Returns values, standard deviations (infinite: not told), those of a repeat."""
    share = 1.0 - np.diag(c)
    share = np.where(share > 1.0 - TOLD**2, share, np.nan)
    again = np.sqrt(np.maximum(np.diag(c - c @ c), votes_sd**2)) / share
    sds = np.maximum(np.sqrt(np.diag(c) / share), again)
    return moved / share, np.where(np.isnan(share), np.inf, sds), again
