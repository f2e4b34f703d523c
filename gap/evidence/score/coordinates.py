"""The fit's own coordinates: φ = ln(θ / start) / ln(1 + scale / start) of constants that are positive, else φ = (θ − start) / scale.

Readings hang on products of constants: a flow on rated flow, full scale and the root of a pressure, a velocity on that and an area. In
logarithms what leaves a product as it is lies on a straight line; else on a curve, which leaves the stiff directions of the posterior at
once. And where only the order of magnitude is known (scale ≥ start: how friction's bristles yield), a tenth is as near as ten times.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.fitting.model import Free, Model
from gap.fitting.sensitivity import MOVE, PRIOR_MOVE
from gap.fitting.simulate import on_logs, simulate
from sim_backend.memory.layout import Vector

_PAIRS = 4  # of readings at a time, for every thread


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
    return np.array([_stretch(f, value) for f, value in zip(model.free, model.theta, strict=True)])


def of_other_priors(jacobian: Array, model: Model, other: Model) -> Array:
    """Rows d readings / dφ of a model's numbers in the coordinates that the same numbers have in another model: with a wide prior a number
    is no logarithm."""
    there = {f.key: f for f in other.free}
    ratios = [_stretch(there.get(f.key, f), value) / _stretch(f, value) for f, value in zip(model.free, model.theta, strict=True)]
    return jacobian if all(ratio == 1.0 for ratio in ratios) else jacobian * np.array(ratios)[:, None, None, None]


def magnitudes(model: Model) -> list[int]:
    """Numbers of which only the order of magnitude is known."""
    return [k for k, f in enumerate(model.free) if _positive(f) and f.start <= f.scale]


def slopes(model: Model, experiments: Sequence[Experiment], numbers: Sequence[int], base: Sequence[Array]) -> list[Array]:
    """d readings / dφ of every log, numbers × windows × samples × channels, from short moves; `base`: readings at the model."""
    return one_way(model, experiments, numbers, base, np.array([PRIOR_MOVE if model.free[k].prior else MOVE for k in numbers]))


def one_way(model: Model, experiments: Sequence[Experiment], numbers: Sequence[int], base: Sequence[Array], reach: Array) -> list[Array]:
    """The same from moves of φ by `reach`: up, or where that leaves the range to the side with more room, no farther than its end."""
    phi, (low, high) = phi_of(model), ends(model)
    vectors, moves = [], []
    for k, far in zip(numbers, reach, strict=True):
        up, down, there = high[k] - phi[k], phi[k] - low[k], phi.copy()
        moves.append(min(far, up) if far <= up or up >= down else -min(far, down))
        there[k] += moves[-1]
        vectors.append(model.vector(theta_of(model, there)))
    if not vectors:
        return [np.empty((0, *r.shape)) for r in base]
    steps = np.array(moves)[:, None, None, None]
    return [(np.stack(moved) - r) / steps for moved, r in zip(on_logs(experiments, vectors), base, strict=True)]


def along(model: Model, experiments: Sequence[Experiment], moves: Array) -> Iterator[Array]:
    """Half of what readings of every log change from −move to +move of φ, for every one of `moves` (moves × numbers): moves × windows ×
    samples × channels; one log at a time, since they fill the memory."""
    phi, (low, high) = phi_of(model), ends(model)
    vectors = [model.vector(theta_of(model, np.clip(phi + side * move, low, high))) for move in moves for side in (1.0, -1.0)]
    for experiment in experiments:
        yield _halved(experiment, vectors)


def _halved(experiment: Experiment, vectors: Sequence[Vector]) -> Array:
    """Half of the difference within every pair; some pairs at a time, since their readings fill the memory."""
    found, step = np.empty((len(vectors) // 2, *experiment.measured.shape)), _PAIRS * max(experiment.workers, 1)
    for first in range(0, len(found), step):
        readings = simulate(experiment, vectors[2 * first : 2 * (first + step)])
        for k, (there, back) in enumerate(zip(readings[::2], readings[1::2], strict=True), first):
            found[k] = 0.5 * (there - back)
    return found


def _positive(free: Free) -> bool:
    return free.prior and free.start > 0.0 and free.low > 0.0


def _stretch(free: Free, value: float) -> float:
    return value * _log_sd(free) / free.scale if _positive(free) else 1.0


def _log_sd(free: Free) -> float:
    return float(np.log1p(free.scale / free.start))


def _phi(free: Free, value: float) -> float:
    return float(np.log(value / free.start)) / _log_sd(free) if _positive(free) else (value - free.start) / free.scale


def _theta(free: Free, phi: float) -> float:
    return free.start * float(np.exp(phi * _log_sd(free))) if _positive(free) else free.start + free.scale * phi
