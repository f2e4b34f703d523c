"""Are the changed constants the same in every log? A wrong value is wrong by as much everywhere; a missing effect that a constant stands
in for makes its best value depend on what the machine was doing.

Every log is fitted by itself, from the constants that are written: what a log does not see stays there. Cochran's
Q = Σ (θ_k − θ̄)² / s_k² over K logs has a χ² distribution of K − 1 degrees of freedom when the constant is one (W. G. Cochran, "The
combination of estimates from different experiments", Biometrics 10, 1954).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

from gap.data.measured import Array
from gap.fitting.evaluation import Costing, Evaluation, evaluate, limits, recounted, rho
from gap.fitting.fit import covariance
from gap.fitting.model import Free, Model
from gap.fitting.nuisance import FORM_OF_FRICTION
from gap.fitting.sensitivity import projected, sensitivities
from gap.outcome.search_state import SearchState

LEAST_P = 0.01  # of all constants together
BLOCK = 3  # neighbouring windows that count as one
_SEEN = 0.95  # posterior over prior standard deviation up to which the logs see a constant
_OF_THE_DAY = ("oil", "initial_temperature_C")


@dataclass(frozen=True, slots=True)
class Steadiness:
    """One constant as every log by itself has it, with standard deviations, and the chance of such differences if it is one."""

    free: Free
    files: tuple[str, ...]
    values: Array
    sds: Array

    @property
    def p(self) -> float:
        weights = 1.0 / self.sds**2
        mean = float(weights @ self.values / weights.sum())
        return float(chi2.sf(float(weights @ (self.values - mean) ** 2), len(self.values) - 1))

    def as_dict(self) -> dict[str, Any]:
        rows = zip(self.files, self.values, self.sds, strict=True)
        return {"by_log": [{"file": name, "value": float(f"{v:.6g}"), "se": float(f"{s:.3g}")} for name, v, s in rows], "p": self.p}

    @property
    def text(self) -> str:
        rows = zip(self.files, self.values, self.sds, strict=True)
        unit = f" {self.free.unit}".rstrip()
        return " and ".join(f"{v:.6g} ± {s:.2g}{unit} in {name}" for name, v, s in rows)


def steadiness(state: SearchState, written: Model, changed: Sequence[int]) -> list[Steadiness]:
    """The changed constants (numbers of the current model), log by log: fitted ones, then the hold-out; from their values in the model
    that is written. Not the form of friction before it slides and the oil's temperature, which no two runs have alike."""
    free = state.current.model.free
    asked = [k for k in changed if free[k].path[-1] not in FORM_OF_FRICTION and free[k].path != _OF_THE_DAY]
    if not asked:
        return []
    model = _with_all_free(state.current.model, written)
    numbers = sorted({*asked, *_seen(state)})
    logs = [evaluate(e.experiment, model, state.costs, e.projection) for e in (*state.current.evaluations, *state.seen)]
    fitted, held = logs[: len(state.experiments)], logs[len(state.experiments) :]
    raw = [j[numbers] for j in state.current.jacobian]
    raw += sensitivities(model, [e.experiment for e in held], numbers, [e.readings for e in held])
    columns = [projected(e, j) for e, j in zip((*fitted, *held), raw, strict=True)]
    return logs_by_themselves(model, logs, columns, state.costs, numbers, asked)


def _with_all_free(model: Model, written: Model) -> Model:
    """The model with every constant free, at what the written one has."""
    values = {free.key: float(value) for free, value in zip(written.free, written.theta, strict=True)}
    return model.with_theta(np.array([values.get(free.key, free.start) for free in model.free]))


def logs_by_themselves(
    model: Model, logs: Sequence[Evaluation], columns: Sequence[Array], costs: Costing, numbers: Sequence[int], asked: Sequence[int]
) -> list[Steadiness]:
    """The constants `asked` of every log. `columns`: sensitivities to the constants `numbers`, which `asked` are among, in noise units."""
    files = _names([e.experiment.log.path for e in logs])
    fits = [_by_itself(e, c, costs) for e, c in zip(logs, columns, strict=True)]
    found = []
    for k in asked:
        at, scale = list(numbers).index(k), model.free[k].scale
        values, sds = (np.array([scale * fit[part][at] for fit in fits]) for part in (0, 1))
        found.append(Steadiness(model.free[k], files, model.theta[k] + values, sds))
    return found


def unsteady(found: Sequence[Steadiness]) -> list[Steadiness]:
    """Those that differ from log to log, by Holm's procedure (S. Holm, Scandinavian Journal of Statistics 6, 1979), worst first."""
    ranked = sorted(found, key=lambda s: s.p)
    passed = [s.p * (len(ranked) - k) < LEAST_P for k, s in enumerate(ranked)]
    return ranked[: passed.index(False)] if False in passed else ranked


def in_words(found: Sequence[Steadiness]) -> str:
    """For the verdict; empty for none."""
    return "; ".join(f"{s.free.key} is not the same in every log ({s.text}; p = {s.p:.1g})" for s in found)


def _names(paths: Sequence[Path]) -> tuple[str, ...]:
    """File names, with their folder where two are called alike."""
    names = [path.name for path in paths]
    return tuple(f"{path.parent.name}/{path.name}" if names.count(path.name) > 1 else path.name for path in paths)


def _seen(state: SearchState) -> list[int]:
    """Constants of which the fitted logs say more than was known before."""
    sd = np.sqrt(np.maximum(np.diag(covariance(state.current, state.costs)), 0.0)) / state.current.model.scales
    return [int(k) for k in np.flatnonzero(sd < _SEEN)]


def _by_itself(now: Evaluation, columns: Array, costs: Costing) -> tuple[Array, Array]:
    """The step from the common constants to those of one log, and standard deviations, in prior standard deviations."""
    step, _ = _moved(now, np.zeros(len(columns)), columns, costs)
    return _moved(now, step, columns, costs)


def _moved(now: Evaluation, step: Array, columns: Array, costs: Costing) -> tuple[Array, Array]:
    """One more step of the log's own fit, from `step`, weighed by what that leaves.

    Of two standard deviations the larger counts: that of the fit, with the correlation time of this log's residual, and that of the
    windows' own votes, which holds whatever the residual is.
    """
    after = replace(now, left=now.left - np.tensordot(step, columns, 1))
    left, limit = after.left, limits(now.experiment, now.left, costs)
    cost = float(rho(now.experiment, left, costs).sum()) / int(np.isfinite(now.experiment.measured).sum())
    temper = max(1.0, cost) * max(costs.tau, recounted(costs, [after]).tau)
    weight = np.minimum(1.0, limit / np.maximum(np.abs(left), 1e-12)) / temper
    flat = (columns * np.sqrt(weight)).reshape(len(columns), -1)
    own = np.eye(len(columns))
    spread = np.linalg.inv(flat @ flat.T + own)
    votes = np.einsum("kwn,wn->kw", columns, left * weight)
    blocks = np.stack([votes[:, k : k + BLOCK].sum(axis=1) for k in range(0, votes.shape[1], BLOCK)], axis=1)
    seen = spread @ (blocks @ blocks.T + own) @ spread
    return step + spread @ (votes.sum(axis=1) - step), np.sqrt(np.maximum(np.diag(spread), np.diag(seen)))
