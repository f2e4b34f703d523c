"""The fit's own coordinates: φ = (θ − start) / scale, and φ = ln(θ / start) / ln(1 + scale / start) where only the order of magnitude of a
constant is known (scale ≥ start: how friction's bristles yield). There a tenth is as near as ten times, and lines are straighter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.fitting.model import Free, Model
from gap.fitting.sensitivity import MOVE, PRIOR_MOVE, sensitivities


def phi_of(model: Model) -> Array:
    """The model's numbers in these coordinates."""
    return np.array([_phi(f, value) for f, value in zip(model.free, model.theta, strict=True)])


def theta_of(model: Model, phi: Array) -> Array:
    """Values for given coordinates."""
    return np.array([_theta(f, value) for f, value in zip(model.free, phi, strict=True)])


def ends(model: Model) -> Array:
    """2 × numbers: where every φ ends, the smaller first."""
    found = np.array([[_phi(f, f.low), _phi(f, f.high)] for f in model.free]).reshape(len(model.free), 2).T
    return np.sort(found, axis=0)


def stretch(model: Model) -> Array:
    """dθ/dφ in scales, at the model's values."""
    return np.array([value * _log_sd(f) / f.scale if _by_magnitude(f) else 1.0 for f, value in zip(model.free, model.theta, strict=True)])


def magnitudes(model: Model) -> list[int]:
    """Numbers of which only the order of magnitude is known."""
    return [k for k, f in enumerate(model.free) if _by_magnitude(f)]


def slopes(
    model: Model, experiments: Sequence[Experiment], numbers: Sequence[int], base: Sequence[Array], widths: Array | None = None
) -> list[Array]:
    """d readings / dφ of every log, numbers × windows × samples × channels, `base`: readings at the model. `widths`: of φ, by how much each
    number is moved for it."""
    own = stretch(model)[list(numbers)]
    usual = np.array([PRIOR_MOVE if model.free[k].prior else MOVE for k in numbers])
    moves = (usual if widths is None else widths) * own
    return [j * own[:, None, None, None] for j in sensitivities(model, experiments, numbers, base, moves)]


def _by_magnitude(free: Free) -> bool:
    return free.prior and 0.0 < free.start <= free.scale and free.low > 0.0


def _log_sd(free: Free) -> float:
    return float(np.log1p(free.scale / free.start))


def _phi(free: Free, value: float) -> float:
    return float(np.log(value / free.start)) / _log_sd(free) if _by_magnitude(free) else (value - free.start) / free.scale


def _theta(free: Free, phi: float) -> float:
    return free.start * float(np.exp(phi * _log_sd(free))) if _by_magnitude(free) else free.start + free.scale * phi
