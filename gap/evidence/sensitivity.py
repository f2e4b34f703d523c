"""Sensitivities of a fitted model, taken along the axes of its posterior and as far as that reaches.

Of many constants only what they do together is known: rated flow, full scale and piston area make one velocity. One of them alone moves the
readings by thousands of noises, so in the difference of such columns the error of each finite difference would stand for what the logs say
of the rest. So readings are moved along the eigenvectors of the posterior's precision, in units of the priors' standard deviations, each
as far as it is known. A shorter move would tell of single events where a joint sticks and slips; one way only, of the curvature as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.noise.unknowns import in_noise
from gap.evidence.score.coordinates import along, one_way, phi_of
from gap.evidence.score.hypothesis import Point, Seen, posterior
from gap.evidence.score.prior import prior_of
from gap.fitting.fit import INVISIBLE

_REACH = 3.0  # posterior standard deviations of a move: at 1, events make the posterior narrower at every renewal
_WIDEST = 3.0  # prior standard deviations of it at most
_NOTHING = 1e-2  # of a prior's precision, what logs say of an axis that is not looked at again
_NARROWEST = 1e-3  # of a number at the end of its range

Numbers = NDArray[np.int64]


def renewed(seen: Seen, point: Point) -> Point:
    """The point with its sensitivities taken anew where they show: along the posterior's axes, both ways; of numbers near the end of their
    range by themselves, away from it."""
    return replace(point, jacobian=_taken(seen, point, seen, point, _shown(point), 1.0 + _NOTHING))


def carried_over(seen: Seen, point: Point, other: Seen) -> Point:
    """The point's model on other logs, all sensitivities taken there, as far as the fitted ones know its numbers."""
    readings = other.readings(point.model)
    nothing = tuple(np.zeros((len(point.model.free), *r.shape)) for r in readings)
    there = Point(point.model, readings, nothing, replace(point.discrepancy, times=()))
    return replace(there, jacobian=_taken(seen, point, other, there, np.ones(len(point.model.free), dtype=bool), 0.0))


def _taken(seen: Seen, point: Point, logs: Seen, there: Point, shown: NDArray[np.bool_], least: float) -> tuple[Array, ...]:
    """d readings / dφ of a point on some logs, `there`: as it is on them; moved as far as what was `seen` knows. Of numbers that are not
    `shown`, and along axes less stiff than `least`, they stay as they are there."""
    precision, phi, prior = posterior(seen, point).precision, phi_of(point.model), prior_of(point.model)
    sd = 1.0 / np.sqrt(prior.precision)
    reach = np.minimum(_REACH * np.sqrt(np.diag(np.linalg.inv(precision))), _WIDEST * sd)
    inside = (phi - prior.low > reach) & (prior.high - phi > reach)
    alone, free = np.flatnonzero(shown & ~inside), np.flatnonzero(shown & inside)
    by_number = one_way(point.model, logs.experiments, list(alone), there.readings, np.maximum(reach, _NARROWEST)[alone])
    by_axis = _along_axes(logs.experiments, there, precision, sd, free, least)
    jacobian = []
    for e, old, own, others in zip(logs.experiments, there.jacobian, by_number, by_axis, strict=True):
        new = old.copy()
        new[alone], new[free] = _known(e, own, old[alone]), in_noise(e, others)
        jacobian.append(new)
    return tuple(jacobian)


def _along_axes(
    experiments: Sequence[Experiment], point: Point, precision: Array, sd: Array, free: Numbers, least: float
) -> Iterator[Array]:
    """d readings / dφ of the numbers `free`, one log after the other, from moves along the axes of their posterior in units of the priors'
    standard deviations `sd`; along axes less stiff than `least` times the priors they stay as they were."""
    own = sd[free]
    stiffness, axes = np.linalg.eigh(own[:, None] * precision[np.ix_(free, free)] * own)
    told = stiffness > least
    lengths = np.minimum(_REACH / np.sqrt(stiffness[told]), _WIDEST)
    moves = np.zeros((int(told.sum()), len(precision)))
    moves[:, free] = (axes[:, told] * lengths).T * own
    kept = (axes[:, ~told] / own[:, None]) @ (axes[:, ~told] * own[:, None]).T
    for e, j, change in zip(experiments, point.jacobian, along(point.model, experiments, moves), strict=True):
        was = j[free] * e.sigma
        if not np.isfinite(change).all():
            change = np.where(np.isfinite(change), change, np.tensordot(moves[:, free], was, 1))
        found = np.tensordot(kept, was, 1)
        found += np.tensordot(axes[:, told] / own[:, None] / lengths, change, 1)
        yield found


def _known(experiment: Experiment, new: Array, old: Array) -> Array:
    """New sensitivities in noise; the old ones where the simulation has run away."""
    return np.where(np.isfinite(new), in_noise(experiment, new), old)


def _shown(point: Point) -> NDArray[np.bool_]:
    energy = sum(np.sum(j**2, axis=(1, 2, 3)) for j in point.jacobian)
    return np.array([not f.prior or energy[k] > INVISIBLE for k, f in enumerate(point.model.free)])
